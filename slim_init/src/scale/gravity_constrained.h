// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Linear least squares with the norm of three unknowns fixed.
#pragma once

#include <Eigen/Core>

namespace slim_init {

/// Global minimum of x^T H x - 2 b^T x with |x.tail<3>()| = gravity_magnitude.
///
/// H symmetric positive semidefinite (lower triangle read). The other unknowns are eliminated; the
/// remaining 3x3 problem (S + mu I) g = m, |g| = G is a secular equation in mu, whose largest root
/// is the global minimum (Gander 1980; He et al. 2023 solve the equivalent sextic). Returns false
/// when H restricted to the other unknowns is not positive definite to working precision or the
/// input is not finite; x is then left alone.
bool solveGravityConstrained(const Eigen::MatrixXd& H, const Eigen::VectorXd& b,
                             double gravity_magnitude, Eigen::VectorXd* x);

/// The 3x3 core of it: minimises g^T S g - 2 m^T g with |g| = G; S symmetric.
Eigen::Vector3d minimizeOnSphere(const Eigen::Matrix3d& S, const Eigen::Vector3d& m, double G);

}  // namespace slim_init
