// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// When the calibration in the host's file should be changed: one window is not enough to say so.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <string>

#include "slim_init/host_health/calibration_lines.h"
#include "slim_init/result.h"

namespace slim_init::vins_adapter {

/// Collects the calibrations that windows without common data have found. Their scatter says how
/// sure the mean is: errors that a window does not know of (motion, IMU scale) differ from window
/// to window. Not thread-safe.
class CalibrationAdvice {
 public:
  static constexpr int kWindows = 8;        ///< fewer say nothing: 25 s of flight
  static constexpr std::size_t kKept = 64;  ///< the newest
  static constexpr double kApart_s = 3.5;   ///< between their newest frames: longer than a window

  explicit CalibrationAdvice(
      const host_health::FileCalibration& file = host_health::FileCalibration())
      : file_(file) {}

  /// The calibration found by a window whose newest frame is at `stamp` [s]. Returns, once, lines
  /// for the host's file with how sure they are, or "".
  std::string add(double stamp, const OptionalCalibration& found);

 private:
  using Error = Eigen::Matrix<double, 8, 1>;  // as CalibrationEstimate::covariance
  struct Window {
    Error error;  // of the file
    CalibrationEstimate found;
  };

  CalibrationEstimate mean() const;

  host_health::FileCalibration file_;
  std::deque<Window> windows_;
  double newest_ = kNotComputed;  // [s]
  bool given_ = false;
};

}  // namespace slim_init::vins_adapter
