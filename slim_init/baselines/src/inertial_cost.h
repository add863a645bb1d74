// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// IMU factor of Ceres between two keyframes with biases of their own: preintegrated motion and bias
// random walk (Forster et al. 2017). A header alone: `openvins` and the back end, which no other
// library joins, both compile it.
#pragma once

#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <cmath>
#include <memory>

#include "estimation/inertial_factor.h"
#include "geometry/so3.h"
#include "imu/preintegration.h"
#include "imu/window_state.h"

namespace slim_init {

/// Whitened residual [rotation, velocity, position, b_g walk, b_a walk] over the blocks pose and
/// motion of keyframe i, pose and motion of keyframe j. Pose: p_w_b, theta with
/// R_w_b = R_ref Exp(theta); motion: v_w_b, b_g, b_a. Biases of keyframe i enter the preintegration
/// to first order.
class InertialCost : public ceres::SizedCostFunction<15, 6, 9, 6, 9> {
 public:
  /// `pre` with covariance; it outlives the cost. `gravity_w` [m/s^2]; walks of the biases
  /// [rad/s^2/sqrt(Hz)] and [m/s^3/sqrt(Hz)]. Null where the covariance is not positive definite.
  static std::unique_ptr<InertialCost> create(const Preintegration& pre,
                                              const Eigen::Matrix3d& R_ref_i,
                                              const Eigen::Matrix3d& R_ref_j,
                                              const Eigen::Vector3d& gravity_w, double gyro_walk,
                                              double accel_walk) {
    std::unique_ptr<InertialCost> cost(new InertialCost(pre, R_ref_i, R_ref_j, gravity_w));
    if (!inertialWhitening(pre, &cost->whitening_)) return nullptr;
    cost->gyro_walk_ = 1.0 / (gyro_walk * std::sqrt(pre.dt));
    cost->accel_walk_ = 1.0 / (accel_walk * std::sqrt(pre.dt));
    return cost;
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    using ConstMap3 = Eigen::Map<const Eigen::Vector3d>;
    WindowState state;
    state.p_b0.resize(3, 2);
    state.v_b0.resize(3, 2);
    for (int k = 0; k < 2; ++k) {
      state.R_b0_bk.push_back(R_ref_[k] * expSO3(ConstMap3(parameters[2 * k] + 3)));
      state.p_b0.col(k) = ConstMap3(parameters[2 * k]);
      state.v_b0.col(k) = ConstMap3(parameters[2 * k + 1]);
    }
    state.gyro_bias = ConstMap3(parameters[1] + 3);
    state.accel_bias = ConstMap3(parameters[1] + 6);
    state.gravity_b0 = gravity_w_;
    InertialResidual factor = inertialResidual(state, 0, pre_);
    Eigen::Map<Eigen::Matrix<double, 15, 1>> r(residuals);
    r.head<9>() = whitening_ * factor.r;
    r.segment<3>(9) = gyro_walk_ * (ConstMap3(parameters[3] + 3) - state.gyro_bias);
    r.tail<3>() = accel_walk_ * (ConstMap3(parameters[3] + 6) - state.accel_bias);
    if (jacobians == nullptr) return true;

    // Columns of the factor: theta_i, p_i, theta_j, p_j, v_i, v_j, b_g, b_a.
    factor.J = whitening_ * factor.J;
    for (int k = 0; k < 2; ++k) {
      if (jacobians[2 * k] != nullptr) {
        Eigen::Map<Eigen::Matrix<double, 15, 6, Eigen::RowMajor>> J(jacobians[2 * k]);
        J.setZero();
        J.topLeftCorner<9, 3>() = factor.J.middleCols<3>(6 * k + 3);
        J.topRightCorner<9, 3>() = factor.J.middleCols<3>(6 * k);
        J.rightCols<3>() *= rightJacobian(ConstMap3(parameters[2 * k] + 3));
      }
      if (jacobians[2 * k + 1] != nullptr) {
        Eigen::Map<Eigen::Matrix<double, 15, 9, Eigen::RowMajor>> J(jacobians[2 * k + 1]);
        J.setZero();
        J.topLeftCorner<9, 3>() = factor.J.middleCols<3>(12 + 3 * k);
        if (k == 0) J.topRightCorner<9, 6>() = factor.J.middleCols<6>(18);
        const double sign = k == 0 ? -1.0 : 1.0;
        J.block<3, 3>(9, 3).diagonal().setConstant(sign * gyro_walk_);
        J.block<3, 3>(12, 6).diagonal().setConstant(sign * accel_walk_);
      }
    }
    return true;
  }

 private:
  InertialCost(const Preintegration& pre, const Eigen::Matrix3d& R_ref_i,
               const Eigen::Matrix3d& R_ref_j, const Eigen::Vector3d& gravity_w)
      : pre_(pre), R_ref_{R_ref_i, R_ref_j}, gravity_w_(gravity_w) {}

  const Preintegration& pre_;
  Eigen::Matrix3d R_ref_[2];
  Eigen::Vector3d gravity_w_;
  Eigen::Matrix<double, 9, 9> whitening_;
  double gyro_walk_ = 0.0, accel_walk_ = 0.0;
};

}  // namespace slim_init
