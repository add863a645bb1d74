// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The bytes are keyframes and samples of any content; the window, where there is one, is solved: by
// `slim` with any of its switches, provisionally, with a known state, or by a compared method.
#include <memory>
#include <string>
#include <vector>

#include "observations.h"
#include "slim_init/baselines/baselines.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/window_solver.h"

using slim_init::InitResult;
using slim_init::InitWindow;
using slim_init::WindowSolver;

namespace {

struct Input {
  slim_init::Calibration calibration;
  std::vector<slim_init::FrameObservation> frames;
  std::vector<slim_init::ImuSample> imu;
};

// Three to ten keyframes of a flight, with some values changed.
Input changedFlight(slim_init::fuzz::Bytes* bytes) {
  const auto& flight = slim_init::fuzz::flight();
  Input input;
  input.calibration = flight.calibration;
  if (bytes->byte() > 200) input.calibration = slim_init::fuzz::rig(bytes);
  input.imu = flight.imu;
  const int keyframes = 3 + bytes->below(8);
  const int step = 1 + bytes->below(4);
  for (int k = 0; k < keyframes && k * step < 40; ++k) {
    input.frames.push_back(flight.keyframes[k * step]);
  }
  slim_init::fuzz::change(&input.frames, &input.imu, bytes);
  return input;
}

Input anything(slim_init::fuzz::Bytes* bytes) {
  Input input;
  input.calibration = slim_init::fuzz::rig(bytes);
  const int keyframes = 2 + bytes->below(7);
  const double interval = 0.05 + 0.01 * bytes->below(20);
  double t = 0.0;
  for (int k = 0; k < keyframes; ++k) {
    input.frames.push_back(slim_init::fuzz::frame(t, bytes));
    t += bytes->byte() < 250 ? interval : bytes->number(1.0);
  }
  for (double s = -0.1; s < keyframes * interval + 0.1; s += 0.01) {
    const double stamp = bytes->byte() < 254 ? s : s + bytes->number(0.1);
    input.imu.push_back(slim_init::fuzz::sample(stamp, bytes));
  }
  return input;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  slim_init::fuzz::Bytes bytes(data, size);
  slim_init::InitializerOptions options = slim_init::fuzz::switched({}, &bytes);
  if (!options.validate().empty()) options = {};
  const int method = bytes.byte(), question = bytes.below(8);
  const Input input = bytes.byte() < 192 ? changedFlight(&bytes) : anything(&bytes);
  std::string error;
  const auto window = InitWindow::create(input.calibration, input.frames, input.imu, &error);
  FUZZ_CHECK(window != nullptr || !error.empty(), "refused without a word");
  if (window == nullptr) return 0;
  const auto& methods = slim_init::baselines::allMethods();
  const std::unique_ptr<WindowSolver> solver = slim_init::baselines::makeMethod(
      methods[method < 200 ? 0 : method % methods.size()].name, options, {}, &error, methods);
  FUZZ_CHECK(solver != nullptr, error);
  InitResult result;
  slim_init::WorkBudget budget(options.limits);
  if (question == 1) {
    result = solver->solve(*window, {nullptr, true}, &budget);
  } else if (question == 2) {
    slim_init::NavState first = slim_init::fuzz::flight().truth.front();
    first.t = window->times().front();
    const slim_init::StatePrior state = slim_init::fuzz::prior(first, &bytes);
    result = solver->solve(*window, {&state}, &budget);
  } else {
    result = solver->solve(*window);
  }
  FUZZ_CHECK(result.validate().empty(), result.validate());
  FUZZ_CHECK(result.status == slim_init::InitStatus::kSuccess || !result.message.empty(),
             "refused without a word");
  return 0;
}
