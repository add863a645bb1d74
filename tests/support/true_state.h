// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>

#include "imu/window_state.h"
#include "support/exact_window.h"

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
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  const StateLayout at(state.size());
  Eigen::VectorXd step(at.size());
  for (Eigen::Index i = 0; i < step.size(); ++i) step[i] = amount * normal(rng);
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

}  // namespace slim_init
