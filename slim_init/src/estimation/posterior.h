// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// From the refined window in b0 to the output: states in the gravity-aligned world, their
// covariance, the standard deviation of the scale.
#pragma once

#include <Eigen/Core>

#include "imu/window_state.h"
#include "slim_init/result.h"

namespace slim_init {

/// Posterior of a refined window.
struct Posterior {
  bool valid = false;  ///< the information is positive definite
  /// Of InitResult's error state, [theta, p, v] per keyframe, then b_g, b_a, in the world frame.
  /// The first position is the origin and has none; the first attitude has that of gravity.
  Eigen::MatrixXd covariance;
  double scale_sigma = kNotComputed;        ///< relative
  double gravity_sigma_rad = kNotComputed;  ///< of the direction, root of the mean over both axes
};

/// `information` as VisualInertialProblem::information().
Posterior posteriorOf(const WindowState& state, const Eigen::MatrixXd& information);

}  // namespace slim_init
