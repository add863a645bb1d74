// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/imu_simulator.h"

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

}  // namespace slim_init::simulation
