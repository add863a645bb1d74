// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// From the covariance of a state in a world whose heading is free to the square root of information
// of a prior that holds it.
#pragma once

#include <Eigen/Core>

#include "slim_init/types.h"

namespace slim_init::backend {

/// `covariance` of the errors [theta, p, v, b_g, b_a] of `state`, theta on the right of R_w_b.
/// `root`: 15x15 J with J^T J the information of [p, theta, v, b_g, b_a] in the world turned and
/// moved such that position and heading of the state are exact to `sigma_p` [m] and `sigma_yaw`
/// [rad]. False where the rest is not positive definite; `root` is then untouched.
bool seedInformation(const NavState& state, const Eigen::Matrix<double, 15, 15>& covariance,
                     double sigma_p, double sigma_yaw, Eigen::MatrixXd* root);

}  // namespace slim_init::backend
