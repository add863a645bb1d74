// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slim_init {

/// Nearest point or line that a start may have [1/m]; nearer ones are wrong matches.
inline constexpr double kMaxStartInverseDistance = 10.0;

/// Derivatives of one view of a track: two residuals, whitened.
template <int D>
struct ViewDerivatives {
  Eigen::Vector2d r;
  Eigen::Matrix<double, 2, 6> J_pose;  ///< against [theta_k, p_k]
  Eigen::Matrix<double, 2, D> J_track;
};

/// Where the camera is at an exposure, seen from the body at its keyframe.
struct CameraPlace {
  // NOLINTNEXTLINE: mostly the lever arm is all.
  CameraPlace(const Eigen::Vector3d& lever, const Eigen::Vector3d& way = Eigen::Vector3d::Zero())
      : t_b_c(lever), moved(way) {}

  Eigen::Vector3d t_b_c;  ///< in the body [m]
  Eigen::Vector3d moved;  ///< of the body from the keyframe to the exposure, in b0 [m]
};

}  // namespace slim_init
