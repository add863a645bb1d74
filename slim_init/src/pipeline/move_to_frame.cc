// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/move_to_frame.h"

#include <cmath>

#include "geometry/so3.h"

namespace slim_init {
namespace {

// The rotation about z that brings R_b closest to R_a. Unlike the difference of two yaw angles it
// is well defined for every mounting, also with a body axis pointing up (EuRoC's x axis does).
Eigen::Matrix3d yawBetween(const Eigen::Matrix3d& R_a, const Eigen::Matrix3d& R_b) {
  const Eigen::Matrix3d M = R_a * R_b.transpose();
  const double yaw = std::atan2(M(1, 0) - M(0, 1), M(0, 0) + M(1, 1));
  return expSO3(Eigen::Vector3d(0.0, 0.0, yaw));
}

}  // namespace

void moveToFrame(const NavState& there, const NavState& here, InitResult* result) {
  const Eigen::Matrix3d R = yawBetween(there.R_w_b, here.R_w_b);
  const Eigen::Vector3d t = there.p_w_b - R * here.p_w_b;
  for (NavState& state : result->states) {
    state.R_w_b = R * state.R_w_b;
    state.p_w_b = R * state.p_w_b + t;
    state.v_w_b = R * state.v_w_b;
  }
  // Attitude errors stand on the body side and do not turn; those of p and v do.
  if (result->covariance.size() == 0) return;
  Eigen::MatrixXd T =
      Eigen::MatrixXd::Identity(result->covariance.rows(), result->covariance.cols());
  for (std::size_t k = 0; k < result->states.size(); ++k) {
    T.block<3, 3>(9 * k + 3, 9 * k + 3) = R;
    T.block<3, 3>(9 * k + 6, 9 * k + 6) = R;
  }
  result->covariance = T * result->covariance * T.transpose();
}

}  // namespace slim_init
