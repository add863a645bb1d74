// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What slim_init_node does between its messages: joins points and lines, asks the initializer when
// there is something new to ask, stops when it has an answer. No ROS here.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slim_init/initializer.h"

namespace slim_init::node {

struct InitSessionOptions {
  /// Between two attempts, time of the data [s]; 0.1 as VINS-Mono. 0: on every frame.
  double attempt_interval_s = 0.1;
  /// A frame waits for its lines until the next frame comes; off where nobody sends lines.
  bool expect_lines = true;

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

struct InitSessionCounts {
  std::int64_t frames = 0;            ///< point messages taken
  std::int64_t line_messages = 0;     ///< line messages taken
  std::int64_t lines_unmatched = 0;   ///< line messages whose frame never came or is forgotten
  std::int64_t frames_uncovered = 0;  ///< given up waiting for IMU samples that cover them
  std::int64_t attempts = 0;          ///< by itself and on request
  std::int64_t successes = 0;
  std::int64_t restarts = 0;  ///< calls of restart()
};

/// One question to the initializer and its answer.
struct Attempt {
  std::int64_t number = 0;  ///< since the start, from 1
  double t = kNotComputed;  ///< newest frame that the IMU covers, camera clock [s]; NaN: none
  bool requested = false;
  double total_ms = kNotComputed;  ///< wall clock
  InitResult result;
};

/// Feeds an initializer from message streams. Times are those of the caller's clock, IMU and camera
/// alike; messages in disorder are dropped and counted by the initializer's window. Not
/// thread-safe.
class InitSession {
 public:
  /// `initializer` is not null; options as they are, call validate() first.
  InitSession(std::unique_ptr<IInitializer> initializer, const InitSessionOptions& options);

  void addImu(const ImuSample& sample);
  /// Points of one image; its lines come by addLines(), before or after.
  void addPoints(FrameObservation frame);
  /// Lines of the image with stamp `t`, which have to agree with that of its points to 0.1 ms.
  void addLines(double t, std::vector<LineObservation> lines);

  /// Whether somebody sends lines may change while the node runs.
  void expectLines(bool expect) { options_.expect_lines = expect; }

  /// Asks the initializer when a new frame is complete, the interval has passed and there is no
  /// answer yet. To be called after every message.
  std::optional<Attempt> poll();

  /// Asks at once, from the data at hand. After a refusal poll() goes on asking, also where there
  /// was an answer before.
  Attempt request();

  /// Forgets all data and the answer.
  void restart();

  bool initialized() const { return initialized_; }
  const IInitializer& initializer() const { return *initializer_; }
  const InitSessionCounts& counts() const { return counts_; }

 private:
  struct PendingFrame {
    double t = 0.0;  // camera clock
    bool has_lines = false;
  };
  struct PendingLines {
    double t = 0.0;
    std::vector<LineObservation> lines;
  };

  Attempt ask(bool requested);

  std::unique_ptr<IInitializer> initializer_;
  InitSessionOptions options_;
  InitSessionCounts counts_;
  std::deque<PendingFrame> frames_;       // not asked about yet
  std::deque<PendingLines> early_lines_;  // their points have not come yet
  double t_imu_ = kNotComputed;
  double t_asked_ = kNotComputed;           // camera clock
  double t_newest_covered_ = kNotComputed;  // camera clock
  bool initialized_ = false;
};

}  // namespace slim_init::node
