// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "geometry/so3.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace slim_init {

double distanceFromRotation(const Eigen::Matrix3d& A) {
  return (A.transpose() * A - Eigen::Matrix3d::Identity()).norm() + std::abs(A.determinant() - 1.0);
}

Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& A) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(2) *= -1.0;
  return U * svd.matrixV().transpose();
}

Eigen::Matrix3d gravityAlignedAttitude(const Eigen::Vector3d& gravity_b) {
  const Eigen::Vector3d up_b = -gravity_b.normalized();
  // World axes expressed in b: z is up, x is the horizontal part of the body's x axis.
  Eigen::Vector3d x_b = Eigen::Vector3d::UnitX() - up_b.x() * up_b;
  Eigen::Vector3d y_b;
  if (x_b.norm() > 1e-6) {
    x_b.normalize();
    y_b = up_b.cross(x_b);
  } else {
    y_b = (Eigen::Vector3d::UnitY() - up_b.y() * up_b).normalized();
    x_b = y_b.cross(up_b);
  }
  Eigen::Matrix3d R_w_b;
  R_w_b.row(0) = x_b.transpose();
  R_w_b.row(1) = y_b.transpose();
  R_w_b.row(2) = up_b.transpose();
  return R_w_b;
}

}  // namespace slim_init
