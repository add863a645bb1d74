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

/// At 10 Hz; `noise`: of the IMU, and 0.6 px of the tracks.
inline ExactWindow flight(bool noise = false) {
  ExactWindowOptions options = atTenHertz(kFrames);
  options.imu_noise = noise;
  if (noise) options.pixel_noise = 0.6;
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
