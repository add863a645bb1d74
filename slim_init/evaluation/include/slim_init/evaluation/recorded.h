// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Recorded inertial data with true motion and image times, without images.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::evaluation {

/// Outcome of reading: no message, or one sentence naming file, line, column and value.
struct ReadStatus {
  std::string message;
  bool ok() const { return message.empty(); }
};

/// Messages of a stream that are not in order or not there.
struct Disorder {
  int repeated = 0;      ///< stamp of an earlier message: dropped
  int out_of_order = 0;  ///< stamp before that of an earlier message: sorted in
  int unreadable = 0;    ///< no file, cannot be read, not finite: dropped
};

/// A recording. All times are relative to the first IMU sample, [s]; the nanoseconds are subtracted
/// as integers, so nothing is lost to the 0.2 microsecond grid of a double at 1.4e9 s.
struct RecordedMotion {
  std::string name;        ///< last component of the directory
  std::int64_t t0_ns = 0;  ///< stamp of the first IMU sample
  std::vector<ImuSample> imu;
  std::vector<SpeedSample> speeds;  ///< of speed0.csv, where there is one
  std::vector<double> image_times;  ///< camera clock, ascending; before 0 where images start first
  /// At the times of the ground truth, ascending; empty without one.
  std::vector<NavState> truth;
  /// Recorded; else v_w_b of `truth` is that of deriveVelocities() and its biases are NaN.
  bool has_velocity_and_bias = false;
  Disorder imu_disorder, image_disorder;  ///< images: of a recording with pixels
  std::vector<std::string> notes;         ///< one sentence per thing dropped or suspicious

  std::int64_t stampNs(double t) const { return t0_ns + std::llround(1e9 * t); }
};

/// Reads DIR/imu0.csv, DIR/cam0_timestamps.csv, DIR/groundtruth.csv and, if it exists,
/// DIR/speed0.csv (docs/evaluation.md, "Input files"). A step between IMU samples that is longer
/// than `max_imu_gap_s` is noted. On an error `motion` is left as it was.
ReadStatus readRecordedMotion(const std::string& directory, double max_imu_gap_s,
                              RecordedMotion* motion);

/// Reads poses in 8 or 17 columns as in a groundtruth.csv into `truth`; times are relative to the
/// first stamp, which becomes `t0_ns`.
ReadStatus readPoses(const std::string& path, RecordedMotion* motion);

}  // namespace slim_init::evaluation
