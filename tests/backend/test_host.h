// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A host for tests: the estimator with an initializer inside, driven through the host adapter as
// VINS-Mono drives it (start, failure detection, re-initialization, reset).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slim_init/backend/sliding_window_estimator.h"
#include "slim_init/vins_adapter/host_adapter.h"

namespace slim_init::backend {

/// What happened with one frame.
struct HostStep {
  bool tracking = false;   ///< `state` is the host's estimate at this frame
  NavState state;          ///< in the odometry frame; IMU clock
  bool seeded = false;     ///< this frame gave the first estimate since construction or a reset
  bool failed = false;     ///< failure detection or watchdog fired, or the optimisation failed
  bool recovered = false;  ///< .. and the initializer filled the window again at once
  bool reset = false;      ///< .. or it declined for good, and the window is empty
  std::string message;     ///< why it failed, and what the initializer reported
};

/// Feeds estimator and adapter alike. Per frame: until it is seeded, the adapter is asked to seed
/// the full window; then the estimator optimises, the failure detection checks the step and the
/// watchdog the window; a window under suspicion is not remembered. After a failure the adapter is
/// asked to recover from the states that are old enough; if it declines, the window is cleared, or
/// kept if it needs more data, and the next seed joins the old odometry frame if the IMU data
/// reach.
class TestHost {
 public:
  /// `max_wait_ms`: of the adapter.
  TestHost(const Calibration& calibration, double max_wait_ms);

  void addImu(const ImuSample& sample);
  HostStep addFrame(const FrameObservation& frame);

  /// What the initializer dropped; the estimator gets it all, as VINS-Mono's would.
  StreamCounts counts() const { return adapter_->info().counts; }

  /// For tests that make it fail.
  SlidingWindowEstimator& estimator() const { return *estimator_; }

 private:
  void seed(HostStep* step);
  void watch(HostStep* step);
  void recover(HostStep* step);
  bool fillWindow(const vins_adapter::HostResult& answer, HostStep* step);
  void leaveOutDamage();
  std::vector<vins_adapter::HostState> healthyStates() const;
  void remember();

  std::unique_ptr<vins_adapter::HostAdapter> adapter_;
  std::unique_ptr<SlidingWindowEstimator> estimator_;
  std::vector<vins_adapter::HostState> healthy_;  ///< of the last seconds, oldest first
  std::optional<vins_adapter::HostState> lost_;   ///< the state to join after a reset
  bool suspect_ = false;                          ///< the watchdog does not trust the window
};

}  // namespace slim_init::backend
