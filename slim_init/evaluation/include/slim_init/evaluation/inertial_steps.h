// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::evaluation {

/// A stretch of inertial data over which gyro and accelerometer are taken as constant.
struct InertialStep {
  double dt = 0.0;        ///< [s]
  Eigen::Vector3d gyro;   ///< mean of both ends [rad/s]
  Eigen::Vector3d accel;  ///< mean of both ends [m/s^2]
};

/// Cuts [t0, t1] at the samples, interpolating linearly at both ends. Returns false when the
/// samples do not cover the interval or a step between them is longer than `max_gap_s`.
bool inertialSteps(const std::vector<ImuSample>& imu, double t0, double t1, double max_gap_s,
                   std::vector<InertialStep>* steps);

}  // namespace slim_init::evaluation
