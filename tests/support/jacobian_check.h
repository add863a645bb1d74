// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The one Jacobian checker of the tests: central differences on the tangent space.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>

namespace slim_init {

/// Jacobian of f at zero by central differences; `f` maps a perturbation (size `inputs`) to a
/// vector. `step` in the unit of the perturbation.
template <typename F>
Eigen::MatrixXd numericJacobian(const F& f, int inputs, double step) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(inputs);
  const Eigen::VectorXd f0 = f(zero);
  Eigen::MatrixXd J(f0.size(), inputs);
  for (int k = 0; k < inputs; ++k) {
    Eigen::VectorXd d = zero;
    d[k] = step;
    const Eigen::VectorXd plus = f(d), minus = f(-d);
    for (Eigen::Index r = 0; r < J.rows(); ++r) J(r, k) = (plus[r] - minus[r]) / (2.0 * step);
  }
  return J;
}

/// Both matrices agree to `tolerance` relative to the larger norm (absolutely below norm 1e-9).
inline ::testing::AssertionResult jacobiansAgree(const Eigen::MatrixXd& analytic,
                                                 const Eigen::MatrixXd& numeric, double tolerance) {
  const double norm = std::max({analytic.norm(), numeric.norm(), 1e-9});
  const double difference = (analytic - numeric).norm() / norm;
  if (difference <= tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << "relative difference " << difference << " above " << tolerance << "\nanalytic\n"
         << analytic << "\nnumeric\n"
         << numeric;
}

}  // namespace slim_init
