// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Closed form of Dong-Si and Mourikis (IROS 2012): with known rotations every observation is linear
// in the point, the first velocity and gravity.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "scale/linear_motion.h"
#include "slim_init/init_window.h"

namespace slim_init::baselines {

/// Solution in b0.
struct ClosedForm {
  bool valid = false;
  Eigen::Vector3d velocity_b0 = Eigen::Vector3d::Zero();
  Eigen::Vector3d gravity_b0 = Eigen::Vector3d::Zero();  ///< length as asked for
  /// One per track handed in; not finite where its views do not fix it.
  std::vector<Eigen::Vector3d> points_b0;
};

/// Minimises over the points f, v_0 and g, |g| fixed, the sum over the observations of
///   | [1 0 -u; 0 1 -v] R_c_b (R_b0_bk^T (f - p_k(v_0, g)) - t_b_c) |^2,
/// p_k the IMU's own position (`motion`, accelerometer bias zero). Each point is eliminated on the
/// null space of its columns. `tracks` index window.pointTracks().
ClosedForm solveClosedForm(const InitWindow& window, const std::vector<int>& tracks,
                           const LinearMotion& motion, const std::vector<Eigen::Matrix3d>& R_b0_bk);

}  // namespace slim_init::baselines
