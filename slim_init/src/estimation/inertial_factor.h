// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Residual of one preintegration against the states at its ends (Forster et al. 2016, section
// VI-B; gravity as an unknown direction).
#pragma once

#include <Eigen/Core>

#include "imu/preintegration.h"
#include "imu/window_state.h"

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

}  // namespace slim_init
