// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>

namespace slim_init::feature_tracker_lines {

/// What is known before looking about the camera's rotation since the image before.
struct RotationPrior {
  bool measured = false;  ///< false: nothing; the rotation below is the identity
  /// Takes directions in the camera at the image before to the camera now.
  Eigen::Matrix3d R_now_before = Eigen::Matrix3d::Identity();
  /// Standard deviation of the rotation times the focal length [px]: what it moves a point by.
  double sigma_px = std::numeric_limits<double>::infinity();
};

}  // namespace slim_init::feature_tracker_lines
