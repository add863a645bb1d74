// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slim_init/init_window.h"

namespace slim_init {

/// Motion of the IMU at one instant, biases taken off.
struct ImuInstant {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();   ///< [rad/s]
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< specific force [m/s^2]
};

/// Means of the samples within 12 ms of each keyframe moved by `td_shift` [s], less the biases
/// [rad/s, m/s^2]. Without one the sample after it, the last one at the end.
std::vector<ImuInstant> imuInstants(const InitWindow& window, double td_shift,
                                    const Eigen::Vector3d& gyro_bias,
                                    const Eigen::Vector3d& accel_bias);

}  // namespace slim_init
