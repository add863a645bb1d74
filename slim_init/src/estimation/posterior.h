// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// From the refined window in b0 to the output: states in the gravity-aligned world, their
// covariance, the standard deviation of the scale.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimation/inertial_factor.h"
#include "imu/window_state.h"
#include "slim_init/result.h"
#include "slim_init/types.h"

namespace slim_init {

/// Posterior of a refined window.
struct Posterior {
  bool valid = false;  ///< the information is positive definite
  /// Of InitResult's error state, [theta, p, v] per keyframe, then b_g, b_a, in the world frame.
  /// The first position is the origin and has none; the first attitude has that of gravity.
  Eigen::MatrixXd covariance;
  double scale_sigma = kNotComputed;  ///< relative
  /// How the errors of `covariance` follow a relative change of the scale, everything else at its
  /// most probable.
  Eigen::VectorXd by_scale;
  /// Of the rig error [rotation, translation, td, readout].
  Eigen::Matrix<double, StateLayout::kRig, StateLayout::kRig> rig_covariance =
      Eigen::Matrix<double, StateLayout::kRig, StateLayout::kRig>::Zero();
};

/// `information` as VisualInertialProblem::information(), without a rig error: the rig is exact.
Posterior posteriorOf(const WindowState& state, const Eigen::MatrixXd& information);

/// The same with a rig error in `state` and `information`: the covariance is that of the body
/// (bodyState()) at the keyframe times moved by the estimated error of td, and contains that of the
/// rig. `instants`: motion of the IMU there.
Posterior posteriorOf(const WindowState& state, const Eigen::MatrixXd& information,
                      const Calibration& calibration, const std::vector<ImuInstant>& instants);

}  // namespace slim_init
