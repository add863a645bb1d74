// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/speed_simulator.h"

#include <algorithm>
#include <cmath>

#include "random.h"

namespace slim_init::simulation {

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
