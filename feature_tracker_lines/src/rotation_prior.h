// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>

namespace slim_init::feature_tracker_lines {

/// Prior knowledge of the camera's rotation since the previous image.
struct RotationPrior {
  bool measured = false;  ///< false: nothing is known; the rotation below is the identity
  /// Maps directions in the camera at the previous image to the camera now.
  Eigen::Matrix3d R_now_before = Eigen::Matrix3d::Identity();
  /// Standard deviation of the rotation times the focal length: how far it moves a point [px].
  double sigma_px = std::numeric_limits<double>::infinity();
};

}  // namespace slim_init::feature_tracker_lines
