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

BodyOffset::BodyOffset(const RigError& rig, const Calibration& calibration)
    : R_b_c(calibration.R_b_c * rig.dR),
      t_b_c(calibration.t_b_c + rig.dt),
      R(calibration.R_b_c * R_b_c.transpose()),
      t(calibration.t_b_c - R * t_b_c) {}

void bodyAtNominalTime(const WindowState& state, int k, const BodyOffset& offset,
                       const LateExposure& exposure, WindowState* nominal,
                       RigDerivatives* derivatives) {
  const double td_error = exposure.td_error;
  const ImuInstant& imu = exposure.imu;
  const Eigen::Matrix3d& R_visual = state.R_b0_bk[k];
  const Eigen::Matrix3d R_body = R_visual * offset.R;
  const Eigen::Vector3d v = state.v_b0.col(k);
  const Eigen::Vector3d acceleration = R_body * imu.force + state.gravity_b0;
  const Eigen::Matrix3d back = expSO3(-td_error * imu.rate);
  nominal->R_b0_bk[k] = R_body * back;
  nominal->p_b0.col(k) = state.p_b0.col(k) + R_visual * offset.t - td_error * v;
  nominal->v_b0.col(k) = v - td_error * acceleration;
  if (derivatives == nullptr) return;

  const double G = state.gravity_b0.norm();
  auto& by_state = derivatives->by_state;
  by_state.setZero();
  by_state.block<3, 3>(0, 0) = (offset.R * back).transpose();
  by_state.block<3, 3>(3, 0) = -R_visual * skew(offset.t);
  by_state.block<3, 3>(3, 3).setIdentity();
  by_state.block<3, 3>(3, 6).diagonal().setConstant(-td_error);
  by_state.block<3, 3>(6, 0) = td_error * R_visual * skew(offset.R * imu.force);
  by_state.block<3, 3>(6, 6).setIdentity();
  auto& by_rig = derivatives->by_rig;
  by_rig.setZero();
  by_rig.block<3, 3>(0, 0) = -back.transpose() * offset.R_b_c;
  by_rig.block<3, 3>(3, 0) = -R_body * skew(offset.t_b_c) * offset.R_b_c;
  by_rig.block<3, 3>(6, 0) = -td_error * R_body * skew(imu.force) * offset.R_b_c;
  by_rig.block<3, 3>(3, 3) = -R_body;
  by_rig.block<3, 1>(0, 6) = -imu.rate;
  by_rig.block<3, 1>(3, 6) = -v;
  by_rig.block<3, 1>(6, 6) = -acceleration;
  derivatives->by_gravity.setZero();
  derivatives->by_gravity.bottomRows<3>() = -td_error * G * tangentBasis(state.gravity_b0 / G);
}

Eigen::Matrix<double, 9, kRigInertialColumns> chainRig(
    const Eigen::Matrix<double, 9, kInertialColumns>& J, const RigDerivatives& i,
    const RigDerivatives& j) {
  // Columns of J: theta_i p_i theta_j p_j v_i v_j, then biases and gravity.
  Eigen::Matrix<double, 9, 9> J_i, J_j;
  J_i << J.middleCols<6>(0), J.middleCols<3>(12);
  J_j << J.middleCols<6>(6), J.middleCols<3>(15);
  const Eigen::Matrix<double, 9, 9> C_i = J_i.lazyProduct(i.by_state);
  const Eigen::Matrix<double, 9, 9> C_j = J_j.lazyProduct(j.by_state);
  Eigen::Matrix<double, 9, kRigInertialColumns> out;
  out.middleCols<6>(0) = C_i.leftCols<6>();
  out.middleCols<6>(6) = C_j.leftCols<6>();
  out.middleCols<3>(12) = C_i.rightCols<3>();
  out.middleCols<3>(15) = C_j.rightCols<3>();
  out.middleCols<8>(18) = J.rightCols<8>();
  out.middleCols<2>(24) += J_i.lazyProduct(i.by_gravity) + J_j.lazyProduct(j.by_gravity);
  out.rightCols<StateLayout::kRig - 1>() = J_i.lazyProduct(i.by_rig) + J_j.lazyProduct(j.by_rig);
  return out;
}

}  // namespace slim_init
