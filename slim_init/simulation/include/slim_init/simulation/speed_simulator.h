// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "slim_init/simulation/trajectory.h"
#include "slim_init/types.h"

namespace slim_init::simulation {

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
