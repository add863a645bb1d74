// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <cmath>

#include "geometry/so3.h"
#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "slim_init/result.h"
#include "support/exact_window.h"
#include "support/gaussian.h"

namespace slim_init {

/// The true motion of a window in its first body frame, as the refinement has it.
inline WindowState trueState(const ExactWindow& exact) {
  WindowState state;
  const NavState& first = exact.truth.front();
  const Eigen::Matrix3d R_b0_w = first.R_w_b.transpose();
  const int n = static_cast<int>(exact.truth.size());
  state.p_b0.resize(3, n);
  state.v_b0.resize(3, n);
  for (int k = 0; k < n; ++k) {
    state.R_b0_bk.push_back(R_b0_w * exact.truth[k].R_w_b);
    state.p_b0.col(k) = R_b0_w * (exact.truth[k].p_w_b - first.p_w_b);
    state.v_b0.col(k) = R_b0_w * exact.truth[k].v_w_b;
  }
  state.gyro_bias = first.gyro_bias;
  state.accel_bias = first.accel_bias;
  state.gravity_b0 = R_b0_w * Eigen::Vector3d(0, 0, -exact.calibration.gravity_magnitude);
  return state;
}

/// Every pose and velocity, the direction of gravity and, where wanted, the biases moved at random;
/// the first pose stays.
inline WindowState moved(const WindowState& state, double amount, unsigned seed, bool biases) {
  Gaussian normal(seed);
  const StateLayout at(state.size());
  Eigen::VectorXd step = Eigen::VectorXd::NullaryExpr(at.size(), [&] { return amount * normal(); });
  step.head<StateLayout::kGauge>().setZero();
  step.segment<3>(at.gyroBias()) *= 0.1;
  if (!biases) step.segment<6>(at.gyroBias()).setZero();
  return retract(state, step);
}

/// The information of a window whose calibration is held, without its part from the rig.
inline Eigen::MatrixXd withoutRig(const Eigen::MatrixXd& information) {
  const Eigen::Index size = information.rows() - StateLayout::kRig;
  return information.topLeftCorner(size, size);
}

/// The true rotations of the cameras, from the first one.
inline std::vector<Eigen::Matrix3d> trueCameraRotations(const ExactWindow& exact) {
  return cameraRotations(trueState(exact).R_b0_bk, exact.calibration.R_b_c);
}

/// The true camera centres in the first body frame, one column per keyframe [m].
inline Eigen::Matrix3Xd trueCentres(const ExactWindow& exact) {
  const WindowState state = trueState(exact);
  Eigen::Matrix3Xd centres(3, state.size());
  for (int k = 0; k < state.size(); ++k) {
    centres.col(k) = cameraCentre(state, k, exact.true_calibration.t_b_c);
  }
  return centres;
}

/// The same about their mean, of unit spread; `metres` is the spread that they had.
inline Eigen::Matrix3Xd trueShape(const ExactWindow& exact, double* metres) {
  Eigen::Matrix3Xd shape = trueCentres(exact);
  const Eigen::Vector3d mean = shape.rowwise().mean();
  shape.colwise() -= mean;
  *metres = shape.norm();
  return shape / *metres;
}

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
