// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/inertial_factor.h"

#include <Eigen/Cholesky>

#include "geometry/so3.h"

namespace slim_init {

InertialResidual inertialResidual(const WindowState& state, int i, const Preintegration& pre) {
  const int j = i + 1;
  const Eigen::Vector3d& g = state.gravity_b0;
  const double dt = pre.dt;
  const Eigen::Matrix3d Rt = state.R_b0_bk[i].transpose();
  const Eigen::Vector3d dbg = state.gyro_bias - pre.gyro_bias;
  const Eigen::Vector3d dtheta = pre.dR_dbg * dbg;
  const Eigen::Vector3d dv_free = Rt * (state.v_b0.col(j) - state.v_b0.col(i) - g * dt);
  const Eigen::Vector3d dp_free =
      Rt * (state.p_b0.col(j) - state.p_b0.col(i) - state.v_b0.col(i) * dt - 0.5 * dt * dt * g);

  InertialResidual out;
  const Eigen::Vector3d r_R = logSO3((pre.dR * expSO3(dtheta)).transpose() * Rt * state.R_b0_bk[j]);
  out.r.head<3>() = r_R;
  out.r.segment<3>(3) = dv_free - pre.velocityAt(state.gyro_bias, state.accel_bias);
  out.r.tail<3>() = dp_free - pre.positionAt(state.gyro_bias, state.accel_bias);

  const Eigen::Matrix3d Jr_inv = rightJacobianInverse(r_R);
  const double G = g.norm();
  const Eigen::Matrix<double, 3, 2> dg = G * tangentBasis(g / G);
  auto& J = out.J;
  J.setZero();
  J.block<3, 3>(0, 0) = -Jr_inv * state.R_b0_bk[j].transpose() * state.R_b0_bk[i];
  J.block<3, 3>(0, 6) = Jr_inv;
  J.block<3, 3>(0, 18) = -Jr_inv * expSO3(r_R).transpose() * rightJacobian(dtheta) * pre.dR_dbg;
  J.block<3, 3>(3, 0) = skew(dv_free);
  J.block<3, 3>(3, 12) = -Rt;
  J.block<3, 3>(3, 15) = Rt;
  J.block<3, 3>(3, 18) = -pre.dv_dbg;
  J.block<3, 3>(3, 21) = -pre.dv_dba;
  J.block<3, 2>(3, 24) = -dt * Rt * dg;
  J.block<3, 3>(6, 0) = skew(dp_free);
  J.block<3, 3>(6, 3) = -Rt;
  J.block<3, 3>(6, 9) = Rt;
  J.block<3, 3>(6, 12) = -dt * Rt;
  J.block<3, 3>(6, 18) = -pre.dp_dbg;
  J.block<3, 3>(6, 21) = -pre.dp_dba;
  J.block<3, 2>(6, 24) = -0.5 * dt * dt * Rt * dg;
  return out;
}

bool inertialWhitening(const Preintegration& pre, Eigen::Matrix<double, 9, 9>* W) {
  const Eigen::LLT<Eigen::Matrix<double, 9, 9>> llt(pre.covariance);
  if (llt.info() != Eigen::Success) return false;
  W->setIdentity();
  llt.matrixL().solveInPlace(*W);
  return W->allFinite();
}

}  // namespace slim_init
