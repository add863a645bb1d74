// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "seed_information.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "geometry/so3.h"

namespace slim_init::backend {

bool seedInformation(const NavState& state, const Eigen::Matrix<double, 15, 15>& covariance,
                     double sigma_p, double sigma_yaw, Eigen::MatrixXd* root) {
  // The world turns back by the error of the heading, up^T theta; the velocity turns with it.
  const Eigen::Vector3d up = state.R_w_b.transpose().col(2);
  Eigen::Matrix<double, 15, 15> T = Eigen::Matrix<double, 15, 15>::Zero();
  T.block<3, 3>(3, 0) = Eigen::Matrix3d::Identity() - up * up.transpose();
  T.block<3, 3>(6, 0) = -Eigen::Vector3d::UnitZ().cross(state.v_w_b) * up.transpose();
  T.block<9, 9>(6, 6).setIdentity();
  Eigen::Matrix<double, 15, 15> P = T * covariance * T.transpose();
  P.topLeftCorner<3, 3>().diagonal().setConstant(sigma_p * sigma_p);
  P.block<3, 3>(3, 3) += sigma_yaw * sigma_yaw * up * up.transpose();
  // In units of the standard deviations: metres, radians and biases differ by powers of ten.
  if (!P.allFinite() || !(P.diagonal().minCoeff() > 0.0)) return false;
  const Eigen::Matrix<double, 15, 1> sigma = P.diagonal().cwiseSqrt();
  const Eigen::Matrix<double, 15, 15> correlation =
      sigma.cwiseInverse().asDiagonal() * P * sigma.cwiseInverse().asDiagonal();
  const Eigen::LLT<Eigen::Matrix<double, 15, 15>> llt(correlation);
  if (llt.info() != Eigen::Success) return false;
  // With P = S L L^T S the residual L^-1 S^-1 dx has unit covariance.
  Eigen::MatrixXd J = sigma.cwiseInverse().asDiagonal().toDenseMatrix();
  llt.matrixL().solveInPlace(J);
  if (!J.allFinite()) return false;
  *root = J;
  return true;
}

}  // namespace slim_init::backend
