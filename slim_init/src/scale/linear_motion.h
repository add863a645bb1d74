// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The motion that the IMU predicts for known attitudes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "imu/preintegration.h"
#include "imu/window_state.h"

namespace slim_init {

/// Positions and velocities as the IMU predicts them in b0, linear in x = [v_0, b_a, g]; b_a is
/// what the preintegrations lack of the accelerometer bias.
struct LinearMotion {
  std::vector<Eigen::Matrix3d> R_b0_bk;               ///< as given
  Eigen::Vector3d gyro_bias, accel_bias;              ///< of the preintegrations
  Eigen::Matrix<double, Eigen::Dynamic, 9> position;  ///< 3N x 9, of the body
  Eigen::VectorXd position0;                          ///< 3N
  Eigen::Matrix<double, Eigen::Dynamic, 9> velocity;  ///< 3N x 9
  Eigen::VectorXd velocity0;                          ///< 3N
  Eigen::VectorXd lever;                              ///< 3N, R_b0_bk t_b_c: body to camera centre
  /// The motion at x.
  WindowState at(const Eigen::Matrix<double, 9, 1>& x) const;
};

/// Chains the preintegrations (made with derivatives) with given attitudes.
LinearMotion linearMotion(const std::vector<Preintegration>& pre,
                          const std::vector<Eigen::Matrix3d>& R_b0_bk,
                          const Eigen::Vector3d& t_b_c);

}  // namespace slim_init
