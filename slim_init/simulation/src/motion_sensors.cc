// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/motion_sensors.h"

#include <algorithm>
#include <cmath>

#include "random.h"

namespace slim_init::simulation {

std::vector<ImuSample> simulateImu(const Trajectory& trajectory,
                                   const ImuSimulationOptions& options) {
  std::vector<ImuSample> samples;
  Random gyro_noise(options.seed, "imu/gyro");
  Random accel_noise(options.seed, "imu/accel");
  const double density_to_sigma = std::sqrt(options.rate_hz);
  const double gyro_sigma = options.noise.gyro_density * density_to_sigma;
  const double accel_sigma = options.noise.accel_density * density_to_sigma;
  const Eigen::Vector3d g_w(0.0, 0.0, -options.gravity_magnitude);

  // A period that divides the duration up to rounding keeps its last sample.
  constexpr double kRounding = 1e-3;  // [samples], epoch stamps resolve 0.2 us
  const double duration = trajectory.end() - trajectory.begin();
  const long long count = static_cast<long long>(duration * options.rate_hz + kRounding) + 1;
  samples.reserve(count);
  for (long long k = 0; k < count; ++k) {
    ImuSample sample;
    sample.t = trajectory.begin() + static_cast<double>(k) / options.rate_hz;
    const Kinematics motion = trajectory.at(sample.t);
    sample.gyro = motion.omega_b + options.gyro_bias + gyro_sigma * gyro_noise.gaussian3();
    sample.accel = motion.R_w_b.transpose() * (motion.a_w_b - g_w) + options.accel_bias +
                   accel_sigma * accel_noise.gaussian3();
    samples.push_back(sample);
  }
  return samples;
}

SpeedSensor simulatedSpeedSensor(const Calibration& calibration) {
  // Camera (z forward, x right, y down) in a frame with x forward, y left, z up.
  Eigen::Matrix3d R_s_c;
  R_s_c << 0, 0, 1,  //
      -1, 0, 0,      //
      0, -1, 0;
  SpeedSensor sensor;
  sensor.calibrated = true;
  sensor.R_b_s = calibration.R_b_c * R_s_c.transpose();
  sensor.t_b_s = sensor.R_b_s * Eigen::Vector3d(-0.5, 0.0, -0.3);
  return sensor;
}

std::vector<SpeedSample> simulateSpeeds(const Trajectory& trajectory, const SpeedSensor& sensor,
                                        const SpeedSimulationOptions& options) {
  Random noise(options.seed, "speed/noise");
  std::vector<SpeedSample> samples;
  for (int k = 0;; ++k) {
    const double t = trajectory.begin() + k / options.rate_hz;
    if (t > trajectory.end()) break;
    const double error = noise.gaussian();
    if (!trajectory.covers(t)) continue;
    const Kinematics motion = trajectory.at(t);
    const Eigen::Vector3d v_b =
        motion.R_w_b.transpose() * motion.v_w_b + motion.omega_b.cross(sensor.t_b_s);
    const double speed = sensor.R_b_s.col(0).dot(v_b);
    const double sigma =
        std::max(SpeedSimulationOptions::kLeastSigma, options.noise * std::abs(speed));
    samples.push_back(SpeedSample::forward(t, speed + sigma * error, sigma));
  }
  return samples;
}

}  // namespace slim_init::simulation
