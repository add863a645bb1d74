// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A generated flight of a host, and damage to its IMU data.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slim_init/types.h"
#include "support/exact_window.h"

namespace slim_init::host_health {

constexpr int kHostFrames = 11;  ///< of the host's window
constexpr int kFrames = 40;      ///< of the flight

constexpr double kNoisePx = 0.6;  ///< of the tracks

/// At 10 Hz; without noise of the tracks the IMU has none either.
inline ExactWindow flightOf(Motion motion, double pixel_noise, unsigned seed = 1,
                            int keyframes = kFrames) {
  ExactWindowOptions options = atTenHertz(keyframes);
  options.motion = motion;
  options.pixel_noise = pixel_noise;
  options.imu_noise = pixel_noise > 0.0;
  options.seed = seed;
  return makeExactWindow(options);
}

/// Adds `accel` and `gyro` to the samples in [first, last).
inline std::vector<ImuSample> disturbed(std::vector<ImuSample> samples, double first, double last,
                                        const Eigen::Vector3d& accel,
                                        const Eigen::Vector3d& gyro = Eigen::Vector3d::Zero()) {
  for (ImuSample& sample : samples) {
    if (sample.t < first || sample.t >= last) continue;
    sample.accel += accel;
    sample.gyro += gyro;
  }
  return samples;
}

}  // namespace slim_init::host_health
