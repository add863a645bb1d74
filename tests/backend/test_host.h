// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A host for tests: the estimator with an initializer inside, driven through the host adapter as
// VINS-Mono drives it (start, failure detection, re-initialization, reset).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/backend/sliding_window_estimator.h"
#include "slim_init/vins_adapter/host_adapter.h"

namespace slim_init::backend {

/// Options of the host and of the adapter that it asks.
struct TestHostOptions {
  TestHostOptions();
  vins_adapter::HostOptions adapter;  ///< reinit and watchdog are on
  /// States of the last moments before a failure was noticed are not trusted [s].
  double suspect_s = 0.5;
};

/// What happened with one frame.
struct HostStep {
  bool tracking = false;   ///< `state` is the host's estimate at this frame
  NavState state;          ///< in the odometry frame; IMU clock
  bool seeded = false;     ///< this frame gave the first estimate since construction or a reset
  bool continued = false;  ///< .. and it continues the odometry frame from before the reset
  bool failed = false;     ///< failure detection or watchdog fired, or the optimisation failed
  bool recovered = false;  ///< .. and the initializer filled the window again at once
  bool waiting = false;    ///< .. or it needs more data: frames stay, the next one tries again
  bool reset = false;      ///< .. or it declined, and the window is empty
  std::string message;     ///< why it failed, and what the initializer reported
};

/// Feeds estimator and adapter alike. Per frame: until it is seeded, the adapter is asked to seed
/// the full window; then the estimator optimises, the failure detection checks the step and the
/// watchdog the window; a window under suspicion is not remembered. After a failure the adapter is
/// asked to recover from the states older than suspect_s; if it declines, the window is cleared,
/// and the next seed joins the old odometry frame if the IMU data reach.
class TestHost {
 public:
  /// Around an initializer. Bad arguments: null, and a message in `error` (may be null).
  static std::unique_ptr<TestHost> create(std::unique_ptr<IInitializer> initializer,
                                          const TestHostOptions& options, std::string* error);

  void addImu(const ImuSample& sample);
  HostStep addFrame(const FrameObservation& frame);

  /// What the initializer dropped; the estimator gets it all, as VINS-Mono's would.
  StreamCounts counts() const { return adapter_->counts(); }

  /// For tests that make it fail.
  SlidingWindowEstimator& estimator() { return *estimator_; }

 private:
  TestHost(std::unique_ptr<vins_adapter::HostAdapter> adapter, const TestHostOptions& options);

  void seed(HostStep* step);
  void watch(HostStep* step);
  void recover(const std::vector<vins_adapter::HostState>& from, HostStep* step);
  bool fillWindow(const vins_adapter::HostResult& answer, HostStep* step);
  void leaveOutDamage();
  std::vector<vins_adapter::HostState> healthyStates() const;
  void remember();

  std::unique_ptr<vins_adapter::HostAdapter> adapter_;
  TestHostOptions options_;
  std::unique_ptr<SlidingWindowEstimator> estimator_;
  std::vector<vins_adapter::HostState> healthy_;  ///< of the last seconds, oldest first
  vins_adapter::HostState lost_;                  ///< the state to join after a reset
  bool is_lost_ = false;
  bool suspect_ = false;  ///< the watchdog does not trust the window
};

}  // namespace slim_init::backend
