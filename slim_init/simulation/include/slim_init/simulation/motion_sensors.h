// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What an IMU and a wheel measure along a motion.
#pragma once

#include <vector>

#include "slim_init/simulation/trajectory.h"
#include "slim_init/types.h"

namespace slim_init::simulation {

/// How to sample an IMU from a motion.
struct ImuSimulationOptions {
  double rate_hz = 200.0;
  ImuNoise noise;  ///< densities; per-sample sigma is density * sqrt(rate_hz)
  Eigen::Vector3d gyro_bias = Eigen::Vector3d(-0.0022, 0.0208, 0.0765);  ///< [rad/s], EuRoC's
  Eigen::Vector3d accel_bias = Eigen::Vector3d(-0.013, 0.10, 0.09);      ///< [m/s^2], EuRoC's
  double gravity_magnitude = 9.81007;                                    ///< [m/s^2]
  unsigned seed = 1;
};

/// Samples gyro = omega_b + bias + noise and accel = R_w_b^T (a_w_b - g_w) + bias + noise at
/// begin() + k / rate_hz over the whole trajectory. Gyro and accelerometer noise are independent
/// streams derived from the seed: the noise of one does not change with the density of the other.
std::vector<ImuSample> simulateImu(const Trajectory& trajectory,
                                   const ImuSimulationOptions& options);

/// How to sample a forward speed from a motion.
struct SpeedSimulationOptions {
  double rate_hz = 50.0;
  /// Standard deviation as a fraction of the speed; at least kLeastSigma, as an encoder has steps.
  double noise = 0.05;
  unsigned seed = 1;

  static constexpr double kLeastSigma = 0.01;  ///< [m/s]
};

/// A sensor half a metre behind and 0.3 m below the body, x along the optical axis, y to the left.
SpeedSensor simulatedSpeedSensor(const Calibration& calibration);

/// Forward speeds of the origin of `sensor` at begin() + k / rate_hz over the whole trajectory,
/// with the standard deviation of their noise.
std::vector<SpeedSample> simulateSpeeds(const Trajectory& trajectory, const SpeedSensor& sensor,
                                        const SpeedSimulationOptions& options);

}  // namespace slim_init::simulation
