// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "inertial_cost.h"

#include <cmath>

#include "estimation/inertial_factor.h"
#include "geometry/so3.h"

namespace slim_init::backend {
namespace {

using Matrix15x6 = Eigen::Matrix<double, 15, 6, Eigen::RowMajor>;
using Matrix15x9 = Eigen::Matrix<double, 15, 9, Eigen::RowMajor>;

}  // namespace

InertialCost::InertialCost(const Frame& i, const Frame& j, const Preintegration& pre,
                           const Eigen::Vector3d& gravity_w)
    : i_(i), j_(j), pre_(pre), gravity_w_(gravity_w) {}

std::unique_ptr<InertialCost> InertialCost::create(const Frame& i, const Frame& j,
                                                   const Preintegration& pre,
                                                   const Eigen::Vector3d& gravity_w,
                                                   double gyro_bias_walk, double accel_bias_walk) {
  std::unique_ptr<InertialCost> cost(new InertialCost(i, j, pre, gravity_w));
  if (!inertialWhitening(pre, &cost->whitening_)) return nullptr;
  cost->gyro_walk_weight_ = 1.0 / (gyro_bias_walk * std::sqrt(pre.dt));
  cost->accel_walk_weight_ = 1.0 / (accel_bias_walk * std::sqrt(pre.dt));
  return cost;
}

bool InertialCost::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const Eigen::Map<const Vector6d> pose_i(parameters[0]), pose_j(parameters[2]);
  const Eigen::Map<const Vector9d> motion_i(parameters[1]), motion_j(parameters[3]);
  const Eigen::Vector3d theta_i = pose_i.tail<3>(), theta_j = pose_j.tail<3>();
  const Eigen::Matrix3d R_i = i_.R_ref * expSO3(theta_i);
  const Eigen::Matrix3d R_j = j_.R_ref * expSO3(theta_j);
  const Eigen::Vector3d v_i = motion_i.head<3>(), v_j = motion_j.head<3>();
  const Eigen::Vector3d b_g = motion_i.segment<3>(3), b_a = motion_i.tail<3>();
  const double dt = pre_.dt;

  const Eigen::Matrix3d R_i_t = R_i.transpose();
  const Eigen::Vector3d dtheta = pre_.dR_dbg * (b_g - pre_.gyro_bias);
  const Eigen::Vector3d dv_free = R_i_t * (v_j - v_i - gravity_w_ * dt);
  const Eigen::Vector3d dp_free =
      R_i_t * (pose_j.head<3>() - pose_i.head<3>() - v_i * dt - 0.5 * dt * dt * gravity_w_);
  const Eigen::Vector3d r_R = logSO3((pre_.dR * expSO3(dtheta)).transpose() * R_i_t * R_j);

  Eigen::Map<Eigen::Matrix<double, 15, 1>> r(residuals);
  Vector9d imu;
  imu << r_R, dv_free - pre_.velocityAt(b_g, b_a), dp_free - pre_.positionAt(b_g, b_a);
  r.head<9>() = whitening_ * imu;
  r.segment<3>(9) = gyro_walk_weight_ * (motion_j.segment<3>(3) - b_g);
  r.tail<3>() = accel_walk_weight_ * (motion_j.tail<3>() - b_a);
  if (jacobians == nullptr) return true;

  const Eigen::Matrix3d Jr_inv = rightJacobianInverse(r_R);
  if (jacobians[0] != nullptr) {
    const Eigen::Matrix3d Jr_i = rightJacobian(theta_i);
    Eigen::Matrix<double, 9, 6> J = Eigen::Matrix<double, 9, 6>::Zero();
    J.block<3, 3>(0, 3) = -Jr_inv * R_j.transpose() * R_i * Jr_i;
    J.block<3, 3>(3, 3) = skew(dv_free) * Jr_i;
    J.block<3, 3>(6, 0) = -R_i_t;
    J.block<3, 3>(6, 3) = skew(dp_free) * Jr_i;
    Eigen::Map<Matrix15x6> out(jacobians[0]);
    out.topRows<9>() = whitening_ * J;
    out.bottomRows<6>().setZero();
  }
  if (jacobians[1] != nullptr) {
    Eigen::Matrix<double, 9, 9> J = Eigen::Matrix<double, 9, 9>::Zero();
    J.block<3, 3>(0, 3) = -Jr_inv * expSO3(r_R).transpose() * rightJacobian(dtheta) * pre_.dR_dbg;
    J.block<3, 3>(3, 0) = -R_i_t;
    J.block<3, 3>(3, 3) = -pre_.dv_dbg;
    J.block<3, 3>(3, 6) = -pre_.dv_dba;
    J.block<3, 3>(6, 0) = -dt * R_i_t;
    J.block<3, 3>(6, 3) = -pre_.dp_dbg;
    J.block<3, 3>(6, 6) = -pre_.dp_dba;
    Eigen::Map<Matrix15x9> out(jacobians[1]);
    out.topRows<9>() = whitening_ * J;
    out.bottomRows<6>().setZero();
    out.block<3, 3>(9, 3).diagonal().setConstant(-gyro_walk_weight_);
    out.block<3, 3>(12, 6).diagonal().setConstant(-accel_walk_weight_);
  }
  if (jacobians[2] != nullptr) {
    Eigen::Matrix<double, 9, 6> J = Eigen::Matrix<double, 9, 6>::Zero();
    J.block<3, 3>(0, 3) = Jr_inv * rightJacobian(theta_j);
    J.block<3, 3>(6, 0) = R_i_t;
    Eigen::Map<Matrix15x6> out(jacobians[2]);
    out.topRows<9>() = whitening_ * J;
    out.bottomRows<6>().setZero();
  }
  if (jacobians[3] != nullptr) {
    Eigen::Map<Matrix15x9> out(jacobians[3]);
    out.setZero();
    out.block<9, 3>(0, 0) = whitening_.block<9, 3>(0, 3) * R_i_t;
    out.block<3, 3>(9, 3).diagonal().setConstant(gyro_walk_weight_);
    out.block<3, 3>(12, 6).diagonal().setConstant(accel_walk_weight_);
  }
  return true;
}

}  // namespace slim_init::backend
