// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "anchor_cost.h"

#include "geometry/so3.h"

namespace slim_init::backend {
namespace {

constexpr double kPositionWeight = 1.0 / AnchorCost::kPosition;
constexpr double kYawWeight = 1.0 / AnchorCost::kYaw;
// Trust in the biases of the seed, standard deviations of 0.02 rad/s and 0.2 m/s^2.
constexpr double kGyroBiasWeight = 1.0 / 0.02;
constexpr double kAccelBiasWeight = 1.0 / 0.2;

}  // namespace

bool AnchorCost::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  const Eigen::Map<const Vector6d> pose(parameters[0]);
  const Eigen::Map<const Vector9d> motion(parameters[1]);
  const Eigen::Vector3d theta = pose.tail<3>();
  const Eigen::Matrix3d R = frame_.R_ref * expSO3(theta);
  // The turn from the seed's attitude, in the world; its vertical part is the change of heading.
  const Eigen::Vector3d turn = logSO3(R * seed_.R_w_b.transpose());

  Eigen::Map<Eigen::Matrix<double, 10, 1>> r(residuals);
  r.head<3>() = kPositionWeight * (pose.head<3>() - seed_.p_w_b);
  r[3] = kYawWeight * turn.z();
  r.segment<3>(4) = kGyroBiasWeight * (motion.segment<3>(3) - seed_.gyro_bias);
  r.tail<3>() = kAccelBiasWeight * (motion.tail<3>() - seed_.accel_bias);
  if (jacobians == nullptr) return true;

  if (jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 10, kPoseSize, Eigen::RowMajor>> J(jacobians[0]);
    J.setZero();
    J.block<3, 3>(0, 0).diagonal().setConstant(kPositionWeight);
    // A turn on the left: the inverse left Jacobian is the right one of the negative vector.
    J.block<1, 3>(3, 3) =
        kYawWeight * (rightJacobianInverse(-turn) * R * rightJacobian(theta)).row(2);
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 10, kMotionSize, Eigen::RowMajor>> J(jacobians[1]);
    J.setZero();
    J.block<3, 3>(4, 3).diagonal().setConstant(kGyroBiasWeight);
    J.block<3, 3>(7, 6).diagonal().setConstant(kAccelBiasWeight);
  }
  return true;
}

}  // namespace slim_init::backend
