// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/linear_motion.h"

namespace slim_init {

LinearMotion linearMotion(const std::vector<Preintegration>& pre,
                          const std::vector<Eigen::Matrix3d>& R_b0_bk,
                          const Eigen::Vector3d& t_b_c) {
  const int n = static_cast<int>(R_b0_bk.size());
  LinearMotion motion;
  motion.R_b0_bk = R_b0_bk;
  motion.gyro_bias = pre.front().gyro_bias;
  motion.accel_bias = pre.front().accel_bias;
  motion.position.setZero(3 * n, 9);
  motion.velocity.setZero(3 * n, 9);
  motion.position0.setZero(3 * n);
  motion.velocity0.setZero(3 * n);
  motion.lever.resize(3 * n);
  motion.velocity.block<3, 3>(0, 0).setIdentity();
  motion.lever.head<3>() = R_b0_bk[0] * t_b_c;
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  for (int k = 0; k + 1 < n; ++k) {
    const Preintegration& p = pre[k];
    const int a = 3 * k, b = 3 * (k + 1);
    motion.position.middleRows<3>(b) =
        motion.position.middleRows<3>(a) + p.dt * motion.velocity.middleRows<3>(a);
    motion.position.block<3, 3>(b, 3) += R_b0_bk[k] * p.dp_dba;
    motion.position.block<3, 3>(b, 6) += 0.5 * p.dt * p.dt * I;
    motion.position0.segment<3>(b) =
        motion.position0.segment<3>(a) + p.dt * motion.velocity0.segment<3>(a) + R_b0_bk[k] * p.dp;
    motion.velocity.middleRows<3>(b) = motion.velocity.middleRows<3>(a);
    motion.velocity.block<3, 3>(b, 3) += R_b0_bk[k] * p.dv_dba;
    motion.velocity.block<3, 3>(b, 6) += p.dt * I;
    motion.velocity0.segment<3>(b) = motion.velocity0.segment<3>(a) + R_b0_bk[k] * p.dv;
    motion.lever.segment<3>(b) = R_b0_bk[k + 1] * t_b_c;
  }
  return motion;
}

WindowState LinearMotion::at(const Eigen::Matrix<double, 9, 1>& x) const {
  const Eigen::VectorXd p = position0 + position * x, v = velocity0 + velocity * x;
  WindowState state;
  state.R_b0_bk = R_b0_bk;
  state.p_b0 = Eigen::Map<const Eigen::Matrix3Xd>(p.data(), 3, state.size());
  state.v_b0 = Eigen::Map<const Eigen::Matrix3Xd>(v.data(), 3, state.size());
  state.gyro_bias = gyro_bias;
  state.accel_bias = accel_bias + x.segment<3>(3);
  state.gravity_b0 = x.tail<3>();
  return state;
}

}  // namespace slim_init
