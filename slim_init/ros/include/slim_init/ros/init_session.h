// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What slim_init_node does between its messages: waits until the newest frame is complete, attempts
// to initialize at an interval, stops after a success. No ROS here.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slim_init/host_health/imu_screen.h"
#include "slim_init/initializer.h"

namespace slim_init::node {

/// When an attempt is made.
struct InitSessionOptions {
  /// Between two attempts, time of the data [s]; 0.1 as VINS-Mono. 0: on every frame.
  double attempt_interval_s = 0.1;
  /// A frame waits for its lines until the next frame comes; off where there is no publisher of
  /// lines.
  bool expect_lines = true;
  /// Rows of the images [px], those of the camera, from which the exposure times of a rolling
  /// shutter are computed (setRows()); 0: those of the observations stay as they are.
  int image_height = 0;
  /// Samples beyond are no measurements (the initializer drops and counts them).
  ImuLimits imu;

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// What the session did; what became of the messages is in streamCounts().
struct InitSessionCounts {
  std::int64_t frames_uncovered = 0;  ///< given up waiting for IMU samples that cover them
  std::int64_t attempts = 0;          ///< by itself and on request
  std::int64_t successes = 0;
  std::int64_t restarts = 0;  ///< calls of restart()
};

/// One call of IInitializer::initialize() and its result.
struct Attempt {
  std::int64_t number = 0;  ///< since the start, from 1
  double t = kNotComputed;  ///< newest frame that the IMU covers, camera clock [s]; NaN: none
  bool requested = false;
  double total_ms = kNotComputed;  ///< wall clock
  InitResult result;
};

/// Feeds an initializer from message streams. Stamps are those of the caller's clock; the
/// initializer checks them. When it reports that time has jumped, the session restarts as well.
/// Not thread-safe.
class InitSession {
 public:
  /// `initializer` is not null; options as they are, call validate() first.
  InitSession(std::unique_ptr<IInitializer> initializer, const InitSessionOptions& options);

  /// kGlitch: also for samples that the screen has discarded (ImuScreen::pass()).
  AddStatus addImu(const ImuSample& sample);
  AddStatus addSpeed(const SpeedSample& sample) { return initializer_->addSpeed(sample); }
  /// Points of one image; its lines come by addLines(), before or after.
  AddStatus addPoints(FrameObservation frame);
  /// Lines of the image with stamp `t`, which has to agree with that of its points to 0.1 ms.
  AddStatus addLines(double t, std::vector<LineObservation> lines);

  /// Whether lines are published may change while the node runs.
  void expectLines(bool expect) { options_.expect_lines = expect; }

  /// Calls the initializer when a new frame is complete, the interval has passed and there was no
  /// success yet. To be called after every message.
  std::optional<Attempt> poll();

  /// Calls the initializer at once, with the data at hand. After a refusal poll() continues to
  /// attempt, also where there was a success before.
  Attempt initialize();

  /// Forgets all data and the estimate.
  void restart();

  bool initialized() const { return initialized_; }
  const InitSessionCounts& counts() const { return counts_; }
  /// Since construction; restart() does not clear it.
  StreamCounts streamCounts() const;

 private:
  struct PendingFrame {
    double t = 0.0;  // camera clock
    bool has_lines = false;
  };

  Attempt attempt(bool requested);
  void findRows(FrameObservation* frame) const;
  void forget();

  std::unique_ptr<IInitializer> initializer_;
  InitSessionOptions options_;
  InitSessionCounts counts_;
  StreamCounts before_restart_;
  host_health::ImuScreen screen_;
  std::deque<PendingFrame> frames_;  // not part of an attempt yet
  double t_imu_ = kNotComputed;
  double t_attempt_ = kNotComputed;         // camera clock
  double t_newest_covered_ = kNotComputed;  // camera clock
  bool initialized_ = false;
};

}  // namespace slim_init::node
