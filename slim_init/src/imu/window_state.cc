// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/window_state.h"

#include "geometry/so3.h"

namespace slim_init {

WindowState retract(const WindowState& state, const Eigen::VectorXd& step) {
  StateLayout at(state.size());
  at.rigs = step.size() > at.size();
  WindowState moved = state;
  for (int k = 0; k < at.n; ++k) {
    moved.R_b0_bk[k] = state.R_b0_bk[k] * expSO3(step.segment<3>(at.pose(k)));
    moved.p_b0.col(k) += step.segment<3>(at.pose(k) + 3);
    moved.v_b0.col(k) += step.segment<3>(at.velocity(k));
  }
  moved.gyro_bias += step.segment<3>(at.gyroBias());
  moved.accel_bias += step.segment<3>(at.accelBias());
  const double G = state.gravity_b0.norm();
  const Eigen::Vector3d up = state.gravity_b0 / G;
  moved.gravity_b0 = G * (up + tangentBasis(up) * step.segment<2>(at.gravity())).normalized();
  if (at.rigs) {
    moved.rig.dR = state.rig.dR * expSO3(step.segment<3>(at.rig()));
    moved.rig.dt += step.segment<3>(at.rig() + 3);
    moved.rig.dtd += step[at.td()];
    moved.rig.dreadout += step[at.readout()];
  }
  return moved;
}

WindowState bodyState(const WindowState& state, const Eigen::Matrix3d& R_b_c,
                      const Eigen::Vector3d& t_b_c) {
  // The camera is where it is: R' R_b_c = R R_b_c dR, p' + R' t_b_c = p + R (t_b_c + dt).
  const Eigen::Matrix3d E = R_b_c * state.rig.dR.transpose() * R_b_c.transpose();
  const Eigen::Vector3d E_t = t_b_c - E * (t_b_c + state.rig.dt);
  WindowState out = state;
  // The frame of the first body, seen from that of the first body under the old calibration.
  const Eigen::Matrix3d to_first = E.transpose() * state.R_b0_bk[0].transpose();
  const Eigen::Vector3d first = state.p_b0.col(0) + state.R_b0_bk[0] * E_t;
  for (int k = 0; k < state.size(); ++k) {
    out.R_b0_bk[k] = to_first * state.R_b0_bk[k] * E;
    out.p_b0.col(k) = to_first * (state.p_b0.col(k) + state.R_b0_bk[k] * E_t - first);
    out.v_b0.col(k) = to_first * state.v_b0.col(k);
  }
  out.gravity_b0 = to_first * state.gravity_b0;
  return out;
}

}  // namespace slim_init
