// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/initializer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "session/snapshot_solve.h"
#include "slim_init/keyframe_window.h"
#include "slim_init/state_at.h"

namespace slim_init {
namespace {

// The keyframes of provisional estimates, twice as dense: half a second of images at 20 Hz.
constexpr int kShortKeyframes = 11;

std::optional<WindowOptions> shortWindow(const InitializerOptions& options) {
  if (!options.provisional.enabled) return std::nullopt;
  WindowOptions window = options.window;
  window.keyframes = kShortKeyframes;
  window.min_keyframes = kMinKeyframes;
  window.min_interval_s = 0.5 * WindowOptions().min_interval_s;
  window.max_span_s = 0.0;
  return window;
}

// The buffer and its lock. A solve runs on a snapshot, without the lock, and leaves its memory here
// if the streams that it belongs to are still the same.
class Initializer : public IInitializer {
 public:
  Initializer(std::unique_ptr<WindowSolver> solver, const Calibration& calibration,
              const InitializerOptions& options)
      : solver_(std::move(solver)),
        short_window_(shortWindow(options)),
        options_(options),
        window_(calibration, options.window, StreamOptions::liveData(options.imu)),
        memory_(options.window.fullSpan()) {}

  AddStatus addImu(const ImuSample& sample) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return noted(window_.addImu(sample));
  }
  AddStatus addFrame(FrameObservation frame) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return noted(window_.addFrame(std::move(frame)));
  }
  AddStatus addLines(double stamp, std::vector<LineObservation> lines) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return window_.addLines(stamp, std::move(lines));
  }
  AddStatus addSpeed(const SpeedSample& sample) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return window_.addSpeed(sample);
  }
  void setTd(double td) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    // Estimates before and after are not of the same instants.
    if (std::abs(td - window_.calibration().td) > ConsistencyCheck::kSameInstant) forget();
    window_.setTd(td);
  }
  void reset() override {
    const std::lock_guard<std::mutex> lock(mutex_);
    window_.reset();
    forget();
  }

  InitResult initialize(const Priors& priors) override {
    // A second solve at the same time is against the contract: it waits.
    const std::lock_guard<std::mutex> one_solve(solving_);
    std::unique_lock<std::mutex> lock(mutex_);
    const std::uint64_t generation = generation_;
    SolveMemory memory = std::exchange(memory_, SolveMemory(options_.window.fullSpan()));
    KeyframeWindow snapshot = window_;
    lock.unlock();
    const InitResult result =
        SnapshotSolve(*solver_, short_window_, options_, std::move(snapshot), priors, &memory)
            .solve();
    lock.lock();
    // After a restart or reset() it is the memory of other streams.
    if (generation == generation_) memory_ = std::move(memory);
    return result;
  }

  bool statesAt(const InitResult& result, const std::vector<double>& times, double max_reach_s,
                std::vector<NavState>* states, std::string* error) const override {
    StateAtOptions options;
    options.max_reach_s = max_reach_s;
    options.max_imu_gap_s = options_.window.max_imu_gap_s;
    return slim_init::statesAt(result, bufferedSamples(), times, options, states, error);
  }

  InitializerInfo info() const override {
    InitializerInfo info;
    info.method = solver_->name();
    info.window_span_s = options_.window.fullSpan();
    const std::lock_guard<std::mutex> lock(mutex_);
    info.calibration = window_.calibration();
    info.counts = window_.counts();
    if (!window_.imu().empty()) info.imu = {window_.imu().front().t, window_.imu().back().t};
    return info;
  }

 private:
  AddStatus noted(AddStatus status) {
    if (status == AddStatus::kRestarted) forget();
    return status;
  }

  void forget() {
    memory_ = SolveMemory(options_.window.fullSpan());
    ++generation_;
  }

  std::vector<ImuSample> bufferedSamples() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::vector<ImuSample>(window_.imu().begin(), window_.imu().end());
  }

  const std::unique_ptr<WindowSolver> solver_;
  const std::optional<WindowOptions> short_window_;  // if provisional estimates are wanted
  const InitializerOptions options_;

  std::mutex solving_;
  mutable std::mutex mutex_;  // of all below
  KeyframeWindow window_;
  SolveMemory memory_;
  std::uint64_t generation_ = 0;  // of the streams that memory_ is of
};

}  // namespace

std::unique_ptr<IInitializer> makeInitializer(std::unique_ptr<WindowSolver> solver,
                                              const Calibration& calibration,
                                              const InitializerOptions& options,
                                              std::string* error) {
  std::string message;
  if (solver == nullptr) {
    message = "the solver is null";
  } else if (message = calibration.validate(); !message.empty()) {
    message = "calibration: " + message;
  } else {
    message = options.validate();
  }
  if (!message.empty()) {
    if (error != nullptr) *error = message;
    return nullptr;
  }
  return std::make_unique<Initializer>(std::move(solver), calibration, options);
}

std::unique_ptr<IInitializer> makeInitializer(const Calibration& calibration,
                                              const InitializerOptions& options,
                                              std::string* error) {
  std::unique_ptr<WindowSolver> solver = makeSlimSolver(options, error);
  if (solver == nullptr) return nullptr;
  return makeInitializer(std::move(solver), calibration, options, error);
}

}  // namespace slim_init
