// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The one streaming entry: command line, ROS node and host adapter feed the same class.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"

namespace slim_init {

/// What became of one message.
enum class AddStatus {
  kAdded,
  kNotFinite,   ///< NaN or infinity in time, gyro or accelerometer: dropped and counted
  kOutOfOrder,  ///< time not after the previous message of its kind: dropped and counted
};

/// Result of cutting a window.
struct WindowCut {
  /// kSuccess with a window, or kTooFewKeyframes / kInvalidInput with none.
  InitStatus status = InitStatus::kTooFewKeyframes;
  std::string message;  ///< one sentence: what was found, what is needed
  std::shared_ptr<const InitWindow> window;
};

/// Ring buffer of IMU samples and frames from which a window can be cut at any moment.
///
/// Not thread-safe: one owner feeds and cuts. Memory is bounded by WindowOptions::buffer_s.
class KeyframeWindow {
 public:
  /// Calibration and options are taken as they are; call their validate() first.
  KeyframeWindow(const Calibration& calibration, const WindowOptions& options);

  /// Appends a sample; time must increase.
  AddStatus addImu(const ImuSample& sample);

  /// Appends a frame; time must increase. The frame may run ahead of the IMU: it is used as soon
  /// as the samples cover it.
  AddStatus addFrame(const FrameObservation& frame);

  /// Gives the frame with stamp `t` (camera clock, to within a tenth of a millisecond) its lines
  /// where they come after it. False, and nothing changes, when there is no such frame or it has
  /// lines already.
  bool addLines(double t, const std::vector<LineObservation>& lines);

  /// Cuts the newest window. Keyframes are chosen backwards from the newest frame that the IMU
  /// covers, each at least `min_interval_s` before the next, up to `keyframes` of them, and never
  /// across a gap in frames (`max_frame_gap_s`) or IMU samples (`max_imu_gap_s`). Fewer than
  /// `min_keyframes` is kTooFewKeyframes.
  WindowCut cut() const;

  /// IMU samples held, oldest first.
  const std::deque<ImuSample>& imu() const { return imu_; }

  const WindowCounts& counts() const { return counts_; }
  const Calibration& calibration() const { return calibration_; }
  const WindowOptions& options() const { return options_; }

  /// Forgets all data and counts.
  void reset();

 private:
  void trim();

  Calibration calibration_;
  WindowOptions options_;
  std::deque<ImuSample> imu_;
  std::deque<FrameObservation> frames_;  // t already on the IMU clock
  WindowCounts counts_;
};

}  // namespace slim_init
