// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <thread>

#include "evaluation/circle_sequence.h"
#include "slim_init/evaluation/protocol.h"

namespace slim_init::evaluation {

/// Stands in for a method whose answers and whose times differ from window to window: successes,
/// refusals and waits, with numbers that no file format likes. Safe to call in parallel.
class VariedSolver : public WindowSolver {
 public:
  explicit VariedSolver(std::string name, double factor = 1.0)
      : name_(std::move(name)), factor_(factor) {}

  const std::string& name() const override { return name_; }

  InitResult solveWindow(const InitWindow& window, const SolveRequest& /*request*/,
                         WorkBudget* /*budget*/) const override {
    ++solved;
    const double t = window.times().front();
    const int trial = static_cast<int>(std::lround(2.0 * t));  // one every half second
    std::this_thread::sleep_for(std::chrono::milliseconds((5 * trial) % 7));
    if (trial % 5 == 3) {
      InitResult wait;
      wait.status = InitStatus::kStationary;
      wait.message = "stands, \"still\",\nat " + std::to_string(t);
      wait.gyro_bias = Eigen::Vector3d::Constant(0.01 / 3.0);
      return wait;
    }
    std::vector<NavState> states;
    for (const double time : window.times()) {
      states.push_back(Circle().state(time));
      states.back().p_w_b *= 1.0 + 0.1 * factor_ * std::sin(3.0 * t);
    }
    InitResult result = perfectResult(states, Circle().g);
    result.scale_sigma = factor_ / (3.0 + trial);
    result.counts.point_tracks = 10 + trial;
    result.stages = {{"one", 0.1 * trial}, {"two", 0.5}};
    result.gates.resize(3);
    result.gates[0].name = GateName::kChi2;
    result.gates[0].explanation = "what was measured";
    result.gates[0].unit = "px";
    result.gates[0].value = std::sqrt(2.0) * t;
    result.gates[0].threshold = std::numeric_limits<double>::infinity();
    result.gates[1].name = GateName::kOther;
    result.gates[2].name = GateName::kScaleSigma;
    result.gates[2].value = -0.0;
    result.gates[2].threshold = -std::numeric_limits<double>::infinity();
    result.gates[2].upper_bound = false;
    result.gates[2].passed = result.gates[2].enforced = true;
    result.gates[2].status_if_failed = InitStatus::kScaleTooUncertain;
    if (trial % 5 == 1) result.status = InitStatus::kInconsistentResiduals;
    return result;
  }

  mutable std::atomic<int> solved{0};

 private:
  std::string name_;
  double factor_;
};

/// An estimator that every answer survives; its numbers tell which answer it was.
inline DownstreamRecord runNothing(const Sequence&, const InitResult& answer) {
  DownstreamRecord record;
  record.ran = true;
  record.seconds = 5.0;
  record.ate = 0.1 * answer.states.front().t;
  return record;
}

/// What a clock says, the same in all windows.
inline void forgetTimes(ProtocolResult* result) {
  for (WindowRecord& window : result->windows) {
    for (MethodRecord& record : window.methods) record.solve_ms = record.solve_cpu_ms = 0.0;
  }
}

}  // namespace slim_init::evaluation
