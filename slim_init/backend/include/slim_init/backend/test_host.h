// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A host for tests: the estimator with an initializer inside, driven through the host adapter as
// VINS-Mono drives it (start, failure detection, re-initialization, reset).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/backend/options.h"
#include "slim_init/backend/sliding_window_estimator.h"
#include "slim_init/vins_adapter/host_adapter.h"

namespace slim_init::backend {

struct TestHostOptions {
  TestHostOptions();
  vins_adapter::HostOptions adapter;  ///< reinit is on
  EstimatorOptions estimator;
  FailureOptions failure;
  /// States of the last moments before a failure was noticed are not trusted [s].
  double suspect_s = 0.5;

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// What happened with one frame.
struct HostStep {
  bool tracking = false;   ///< `state` is the host's estimate at this frame
  NavState state;          ///< in the odometry frame; IMU clock
  bool started = false;    ///< this frame gave the first estimate since a start or a reset
  bool joined = false;     ///< .. and it continues the odometry frame from before the reset
  bool failed = false;     ///< the failure detection fired, or the optimisation failed
  bool recovered = false;  ///< .. and the initializer re-seeded the window at once
  bool waiting = false;    ///< .. or it needs more data: frames stay, the next one asks again
  bool reset = false;      ///< .. or it declined, and the window is empty
  FrameReport report;      ///< of the estimator
  std::string sentence;    ///< why it failed, and what the initializer said
};

/// Feeds estimator and adapter alike. Per frame: while not started, the adapter is asked to seed
/// the full window; then the estimator optimises and the failure detection looks at the step. After
/// a failure the adapter is asked to recover from the last state older than suspect_s; declined,
/// the window is cleared, and the next start joins the old odometry frame for
/// HostOptions::max_join_s.
class TestHost {
 public:
  /// About an initializer. Bad arguments: null, and a sentence in `error` (may be null).
  static std::unique_ptr<TestHost> create(std::unique_ptr<IInitializer> initializer,
                                          const TestHostOptions& options, std::string* error);

  void addImu(const ImuSample& sample);
  HostStep addFrame(const FrameObservation& frame);

  /// Asks for a new start in flight, served with the next frame: as after a failure, but the newest
  /// state is trusted, and declined, the host goes on.
  void requestReinit() { requested_ = true; }

  /// What the adapter dropped; the estimator gets it all, as VINS-Mono's would.
  vins_adapter::HostCounts counts() const { return adapter_->counts(); }

  /// For tests that make it fail.
  SlidingWindowEstimator& estimator() { return estimator_; }

 private:
  TestHost(std::unique_ptr<vins_adapter::HostAdapter> adapter, const TestHostOptions& options);

  void start(HostStep* step);
  void recover(const vins_adapter::HostState& from, bool failed, HostStep* step);
  bool seed(const vins_adapter::HostAnswer& answer, HostStep* step);
  vins_adapter::HostState healthyState() const;
  void remember(const NavState& state);

  std::unique_ptr<vins_adapter::HostAdapter> adapter_;
  TestHostOptions options_;
  SlidingWindowEstimator estimator_;
  std::vector<vins_adapter::HostState> healthy_;  ///< of the last seconds, oldest first
  vins_adapter::HostState lost_;                  ///< the state to join after a reset
  bool is_lost_ = false;
  bool requested_ = false;
};

}  // namespace slim_init::backend
