// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <cmath>

#include "geometry/so3.h"
#include "slim_init/result.h"
#include "support/exact_window.h"

namespace slim_init {

/// Errors of the newest state in the body, velocity and vertical, and their squares over the
/// covariance per degree of freedom.
struct NewestError {
  double velocity = 0.0, velocity_squared = 0.0;  ///< [m/s]
  double tilt_deg = 0.0, tilt_squared = 0.0;
};

inline NewestError newestError(const InitResult& answer, const ExactWindow& exact) {
  const NavState &state = answer.states.back(), &truth = exact.truth.back();
  const auto n = static_cast<Eigen::Index>(answer.states.size());
  const Eigen::Matrix<double, 9, 9> P = answer.covariance.block<9, 9>(9 * (n - 1), 9 * (n - 1));
  const Eigen::Matrix3d Rt = state.R_w_b.transpose();
  const Eigen::Vector3d v = Rt * state.v_w_b, up = Rt.col(2);
  const Eigen::Vector3d of_v = v - truth.R_w_b.transpose() * truth.v_w_b;
  Eigen::Matrix<double, 3, 9> J;
  J << skew(v), Eigen::Matrix3d::Zero(), Rt;
  const Eigen::Matrix<double, 2, 3> B = tangentBasis(up).transpose();
  const Eigen::Vector2d tilt = B * (up - truth.R_w_b.transpose().col(2));
  const Eigen::Matrix<double, 2, 3> T = B * skew(up);
  const Eigen::Matrix2d of_tilt = T * P.topLeftCorner<3, 3>() * T.transpose();
  return {of_v.norm(), of_v.dot((J * P * J.transpose()).ldlt().solve(of_v)) / 3.0,
          tilt.norm() * 180.0 / M_PI, tilt.dot(of_tilt.ldlt().solve(tilt)) / 2.0};
}

}  // namespace slim_init
