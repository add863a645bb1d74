// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "anchor_cost.h"

#include "geometry/so3.h"

namespace slim_init::backend {

AnchorCost::AnchorCost(const Frame& frame, const NavState& seed, const EstimatorOptions& options)
    : frame_(frame),
      seed_(seed),
      position_weight_(1.0 / options.anchor_position_m),
      yaw_weight_(1.0 / options.anchor_yaw_rad),
      gyro_bias_weight_(1.0 / options.seed_gyro_bias),
      accel_bias_weight_(1.0 / options.seed_accel_bias) {}

bool AnchorCost::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  const Eigen::Map<const Vector6d> pose(parameters[0]);
  const Eigen::Map<const Vector9d> motion(parameters[1]);
  const Eigen::Vector3d theta = pose.tail<3>();
  const Eigen::Matrix3d R = frame_.R_ref * expSO3(theta);
  // The turn from the seed's attitude, in the world; its vertical part is the change of heading.
  const Eigen::Vector3d turn = logSO3(R * seed_.R_w_b.transpose());

  Eigen::Map<Eigen::Matrix<double, 10, 1>> r(residuals);
  r.head<3>() = position_weight_ * (pose.head<3>() - seed_.p_w_b);
  r[3] = yaw_weight_ * turn.z();
  r.segment<3>(4) = gyro_bias_weight_ * (motion.segment<3>(3) - seed_.gyro_bias);
  r.tail<3>() = accel_bias_weight_ * (motion.tail<3>() - seed_.accel_bias);
  if (jacobians == nullptr) return true;

  if (jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 10, kPoseSize, Eigen::RowMajor>> J(jacobians[0]);
    J.setZero();
    J.block<3, 3>(0, 0).diagonal().setConstant(position_weight_);
    // A turn on the left: the inverse left Jacobian is the right one of the negative vector.
    J.block<1, 3>(3, 3) =
        yaw_weight_ * (rightJacobianInverse(-turn) * R * rightJacobian(theta)).row(2);
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 10, kMotionSize, Eigen::RowMajor>> J(jacobians[1]);
    J.setZero();
    J.block<3, 3>(4, 3).diagonal().setConstant(gyro_bias_weight_);
    J.block<3, 3>(7, 6).diagonal().setConstant(accel_bias_weight_);
  }
  return true;
}

}  // namespace slim_init::backend
