// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/imu_simulator.h"

#include <cmath>

#include "random.h"
#include "range_message.h"

namespace slim_init::simulation {

std::string ImuSimulationOptions::validate() const {
  std::string message;
  requireWithin("rate_hz", rate_hz, 1.0, 1e4, &message);
  requireWithin("noise.gyro_density", noise.gyro_density, 0.0, 1.0, &message);
  requireWithin("noise.accel_density", noise.accel_density, 0.0, 10.0, &message);
  requireWithin("norm of gyro_bias", gyro_bias.norm(), 0.0, 10.0, &message);
  requireWithin("norm of accel_bias", accel_bias.norm(), 0.0, 100.0, &message);
  requireWithin("gravity_magnitude", gravity_magnitude, 0.0, 100.0, &message);
  return message;
}

std::vector<ImuSample> simulateImu(const Trajectory& trajectory,
                                   const ImuSimulationOptions& options) {
  std::vector<ImuSample> samples;
  if (!options.validate().empty()) return samples;

  Random gyro_noise(options.seed, "imu/gyro");
  Random accel_noise(options.seed, "imu/accel");
  const double density_to_sigma = options.add_noise ? std::sqrt(options.rate_hz) : 0.0;
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
