// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "reprojection_cost.h"

#include "geometry/so3.h"

namespace slim_init::backend {

TransferredPoint transferPoint(const Eigen::Matrix3d& R_i, const Eigen::Vector3d& p_i,
                               const Eigen::Matrix3d& R_j, const Eigen::Vector3d& p_j,
                               const Calibration& calibration, const Eigen::Vector3d& bearing_i,
                               double lambda) {
  TransferredPoint out;
  out.in_b_i = calibration.R_b_c * bearing_i + lambda * calibration.t_b_c;
  out.in_b_j = R_j.transpose() * (R_i * out.in_b_i + lambda * (p_i - p_j));
  out.q = calibration.R_b_c.transpose() * (out.in_b_j - lambda * calibration.t_b_c);
  return out;
}

ReprojectionCost::ReprojectionCost(const Frame& i, const Frame& j, const Calibration& calibration,
                                   const Eigen::Vector3d& bearing_i,
                                   const Eigen::Vector3d& bearing_j, double sigma)
    : i_(i),
      j_(j),
      calibration_(calibration),
      bearing_i_(bearing_i),
      weighted_tangent_(tangentBasis(bearing_j).transpose() / sigma) {}

bool ReprojectionCost::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const Eigen::Map<const Vector6d> pose_i(parameters[0]), pose_j(parameters[1]);
  const double lambda = parameters[2][0];
  const Eigen::Vector3d theta_i = pose_i.tail<3>(), theta_j = pose_j.tail<3>();
  const Eigen::Matrix3d R_i = i_.R_ref * expSO3(theta_i);
  const Eigen::Matrix3d R_j = j_.R_ref * expSO3(theta_j);
  const TransferredPoint point =
      transferPoint(R_i, pose_i.head<3>(), R_j, pose_j.head<3>(), calibration_, bearing_i_, lambda);
  const double norm = point.q.norm();
  if (!(norm > 1e-9)) return false;
  const Eigen::Vector3d direction = point.q / norm;
  Eigen::Map<Eigen::Vector2d> r(residuals);
  r = weighted_tangent_ * direction;
  if (jacobians == nullptr) return true;

  using RowJacobian = Eigen::Matrix<double, 2, kPoseSize, Eigen::RowMajor>;
  const Eigen::Matrix<double, 2, 3> dr_dq =
      weighted_tangent_ * (Eigen::Matrix3d::Identity() - direction * direction.transpose()) / norm;
  const Eigen::Matrix<double, 2, 3> dr_db_j = dr_dq * calibration_.R_b_c.transpose();
  const Eigen::Matrix<double, 2, 3> dr_dw = dr_db_j * R_j.transpose();
  if (jacobians[0] != nullptr) {
    Eigen::Map<RowJacobian> J(jacobians[0]);
    J.leftCols<3>() = lambda * dr_dw;
    J.rightCols<3>() = -dr_dw * R_i * skew(point.in_b_i) * rightJacobian(theta_i);
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<RowJacobian> J(jacobians[1]);
    J.leftCols<3>() = -lambda * dr_dw;
    J.rightCols<3>() = dr_db_j * skew(point.in_b_j) * rightJacobian(theta_j);
  }
  if (jacobians[2] != nullptr) {
    Eigen::Map<Eigen::Vector2d> J(jacobians[2]);
    J = dr_db_j *
        (R_j.transpose() * (R_i * calibration_.t_b_c + pose_i.head<3>() - pose_j.head<3>()) -
         calibration_.t_b_c);
  }
  return true;
}

}  // namespace slim_init::backend
