// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "refinement/posterior.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "geometry/so3.h"

namespace slim_init {
namespace {

// d alpha / d gravity, 3x2: how the attitude A of b0 in the world, A Exp(alpha), follows the
// direction of gravity. The yaw of the first body stays zero, which has no simple closed form;
// central differences of a smooth function are good to 1e-9.
Eigen::Matrix<double, 3, 2> attitudeFromGravity(const Eigen::Vector3d& gravity_b0) {
  constexpr double kStep = 1e-5;
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

Posterior posteriorOf(const MapState& state, const Eigen::MatrixXd& information) {
  Posterior out;
  const MapLayout at(state.size());
  const int m = at.size() - MapLayout::kGauge;
  const Eigen::LLT<Eigen::MatrixXd> llt(information);
  if (llt.info() != Eigen::Success) return out;
  const Eigen::MatrixXd covariance = llt.solve(Eigen::MatrixXd::Identity(m, m));
  if (!covariance.allFinite()) return out;

  // A relative change of scale moves every position along its offset from the mean.
  const Eigen::Matrix3Xd centred = state.p_b0.colwise() - state.p_b0.rowwise().mean();
  Eigen::VectorXd along = Eigen::VectorXd::Zero(m);
  for (int k = 1; k < at.n; ++k) {
    along.segment<3>(at.pose(k) + 3 - MapLayout::kGauge) = centred.col(k) / centred.squaredNorm();
  }
  out.scale_sigma = std::sqrt(along.dot(covariance * along));
  const int gravity = at.gravity() - MapLayout::kGauge;
  out.gravity_sigma_rad = std::sqrt(0.5 * covariance.block<2, 2>(gravity, gravity).trace());

  // Errors in the world against errors in b0: x_w = A x_b0 with A = A(gravity).
  const Eigen::Matrix3d A = gravityAlignedAttitude(state.gravity_b0);
  const Eigen::Matrix<double, 3, 2> dalpha = attitudeFromGravity(state.gravity_b0);
  // The map T from one to the other is made of 3x3 blocks; applied from the left to a matrix X.
  const auto toWorld = [&](const Eigen::MatrixXd& X) {
    Eigen::MatrixXd Y(9 * at.n + 6, X.cols());
    const Eigen::Matrix<double, 3, Eigen::Dynamic> alpha = dalpha * X.middleRows<2>(gravity);
    for (int k = 0; k < at.n; ++k) {
      auto theta = Y.middleRows<3>(9 * k);
      auto p = Y.middleRows<3>(9 * k + 3);
      theta.noalias() = state.R_b0_bk[k].transpose() * alpha;
      if (k > 0) {
        const int pose = at.pose(k) - MapLayout::kGauge;
        theta += X.middleRows<3>(pose);
        p.noalias() = A * X.middleRows<3>(pose + 3);
        p.noalias() -= A * skew(state.p_b0.col(k)) * alpha;
      } else {
        p.setZero();
      }
      auto v = Y.middleRows<3>(9 * k + 6);
      v.noalias() = A * X.middleRows<3>(at.velocity(k) - MapLayout::kGauge);
      v.noalias() -= A * skew(state.v_b0.col(k)) * alpha;
    }
    Y.bottomRows<6>() = X.middleRows<6>(at.gyroBias() - MapLayout::kGauge);
    return Y;
  };
  out.covariance = toWorld(toWorld(covariance).transpose());
  out.valid = out.covariance.allFinite();
  return out;
}

}  // namespace slim_init
