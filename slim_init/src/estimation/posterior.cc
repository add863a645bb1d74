// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/posterior.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "estimation/constants.h"
#include "geometry/so3.h"

namespace slim_init {
namespace {

// d alpha / d gravity, 3x2: how the attitude A of b0 in the world, A Exp(alpha), follows the
// direction of gravity. The yaw of the first body stays zero, which has no simple closed form;
// central differences of a smooth function are good to 1e-9.
Eigen::Matrix<double, 3, 2> attitudeFromGravity(const Eigen::Vector3d& gravity_b0) {
  constexpr double kStep = estimation_constants::kGravityStep;
  const double G = gravity_b0.norm();
  const Eigen::Vector3d down = gravity_b0 / G;
  const Eigen::Matrix<double, 3, 2> B = tangentBasis(down);
  const Eigen::Matrix3d A = gravityAlignedAttitude(gravity_b0);
  Eigen::Matrix<double, 3, 2> J;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d plus = (down + kStep * B.col(i)).normalized() * G;
    const Eigen::Vector3d minus = (down - kStep * B.col(i)).normalized() * G;
    J.col(i) = (logSO3(A.transpose() * gravityAlignedAttitude(plus)) -
                logSO3(A.transpose() * gravityAlignedAttitude(minus))) /
               (2.0 * kStep);
  }
  return J;
}

}  // namespace

Posterior posteriorOf(const WindowState& state, const Eigen::MatrixXd& information) {
  Posterior out;
  const StateLayout at(state.size());
  const int m = at.size() - StateLayout::kGauge;
  const Eigen::LLT<Eigen::MatrixXd> llt(information);
  if (llt.info() != Eigen::Success) return out;

  // A relative change of scale moves every position along its offset from the mean.
  const Eigen::Matrix3Xd centred = state.p_b0.colwise() - state.p_b0.rowwise().mean();
  Eigen::VectorXd along = Eigen::VectorXd::Zero(m);
  for (int k = 1; k < at.n; ++k) {
    along.segment<3>(at.pose(k) + 3 - StateLayout::kGauge) = centred.col(k) / centred.squaredNorm();
  }
  const int gravity = at.gravity() - StateLayout::kGauge;
  Eigen::MatrixXd of_gravity = Eigen::MatrixXd::Zero(m, 2);
  of_gravity.middleRows<2>(gravity).setIdentity();

  // Errors in the world are T x for errors x in b0: x_w = A x_b0 with A = A(gravity).
  const Eigen::Matrix3d A = gravityAlignedAttitude(state.gravity_b0);
  const Eigen::Matrix<double, 3, 2> dalpha = attitudeFromGravity(state.gravity_b0);
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(9 * at.n + 6, m);
  for (int k = 0; k < at.n; ++k) {
    const int theta = 9 * k, p = 9 * k + 3, v = 9 * k + 6;
    T.block<3, 2>(theta, gravity) = state.R_b0_bk[k].transpose() * dalpha;
    if (k > 0) {
      const int pose = at.pose(k) - StateLayout::kGauge;
      T.block<3, 3>(theta, pose).setIdentity();
      T.block<3, 3>(p, pose + 3) = A;
      T.block<3, 2>(p, gravity) = -A * skew(state.p_b0.col(k)) * dalpha;
    }
    T.block<3, 3>(v, at.velocity(k) - StateLayout::kGauge) = A;
    T.block<3, 2>(v, gravity) = -A * skew(state.v_b0.col(k)) * dalpha;
  }
  T.block<6, 6>(9 * at.n, at.gyroBias() - StateLayout::kGauge).setIdentity();

  // With the information L L^T, the covariance of T x is (L^-1 T^T)^T (L^-1 T^T).
  out.scale_sigma = llt.matrixL().solve(along).norm();
  out.gravity_sigma_rad = llt.matrixL().solve(of_gravity).norm() * std::sqrt(0.5);
  const Eigen::MatrixXd root = llt.matrixL().solve(T.transpose());
  out.covariance.setZero(T.rows(), T.rows());
  out.covariance.selfadjointView<Eigen::Lower>().rankUpdate(root.transpose());
  out.covariance.triangularView<Eigen::StrictlyUpper>() = out.covariance.transpose();
  out.valid = out.covariance.allFinite();
  return out;
}

}  // namespace slim_init
