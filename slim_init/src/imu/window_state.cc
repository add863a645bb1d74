// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/window_state.h"

#include "geometry/so3.h"

namespace slim_init {

WindowState retract(const WindowState& state, const Eigen::VectorXd& step) {
  const StateLayout at(state.size());
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
  return moved;
}

}  // namespace slim_init
