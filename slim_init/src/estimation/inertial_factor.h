// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Residual of one preintegration against the states at its ends (Forster et al. 2016, section
// VI-B; gravity as an unknown direction), and the error of the rig in it: from the states of the
// visual part, at the exposures and under the calibration of the window, to those of the body at
// the ends of the preintegrations (docs/derivation.md, 4.10). So the rig error enters the IMU
// factors alone, and the tracks, whose number is a hundred times theirs, are free of it.
#pragma once

#include <Eigen/Core>

#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "priors/sensor_priors.h"
#include "slim_init/types.h"

namespace slim_init {

/// Columns of the Jacobian of one factor: theta_i, p_i, theta_j, p_j, v_i, v_j, b_g, b_a, gravity.
constexpr int kInertialColumns = 26;

/// Residual [rotation, velocity, position] of the pair (i, i + 1), in b_i, with derivatives.
struct InertialResidual {
  Eigen::Matrix<double, 9, 1> r;
  Eigen::Matrix<double, 9, kInertialColumns> J;
};

/// Evaluates the residual of keyframes i and i + 1. `pre` was made with derivatives; biases of the
/// state enter to first order about its linearisation point.
InertialResidual inertialResidual(const WindowState& state, int i, const Preintegration& pre);

/// Square root W of the information: W^T W = covariance^-1. False when the covariance is not
/// positive definite.
bool inertialWhitening(const Preintegration& pre, Eigen::Matrix<double, 9, 9>* W);

/// Derivative of the error [theta, p, v] of the body at the end of a preintegration.
struct RigDerivatives {
  Eigen::Matrix<double, 9, 9> by_state;                    ///< by [theta, p, v] of the visual part
  Eigen::Matrix<double, 9, StateLayout::kRig - 1> by_rig;  ///< by rotation, translation, td
  Eigen::Matrix<double, 9, 2> by_gravity;
};

/// Rotation and lever arm from the body under the calibration to the body itself.
struct BodyOffset {
  Eigen::Matrix3d R_b_c;  ///< with the error
  Eigen::Vector3d t_b_c;
  Eigen::Matrix3d R;  ///< R_b0_b = R_b0_b' R
  Eigen::Vector3d t;  ///< p_b0_b = p_b0_b' + R_b0_b' t

  BodyOffset(const RigError& rig, const Calibration& calibration);
};

/// An exposure after its nominal time.
struct LateExposure {
  double td_error;        ///< it follows by [s]
  const ImuInstant& imu;  ///< motion in between
};

/// Body of keyframe k at its nominal time: first order in the motion between that and the exposure.
void bodyAtNominalTime(const WindowState& state, int k, const BodyOffset& offset,
                       const LateExposure& exposure, WindowState* nominal,
                       RigDerivatives* derivatives);

/// Columns of the Jacobian of one factor with a rig error: those of InertialResidual, then
/// rotation, translation, td.
constexpr int kRigInertialColumns = kInertialColumns + StateLayout::kRig - 1;

/// Chains the residual at the nominal states with their derivatives at both ends.
Eigen::Matrix<double, 9, kRigInertialColumns> chainRig(
    const Eigen::Matrix<double, 9, kInertialColumns>& J, const RigDerivatives& i,
    const RigDerivatives& j);

}  // namespace slim_init
