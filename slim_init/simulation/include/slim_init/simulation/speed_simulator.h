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
  double scale_error = 0.0;  ///< relative error of all measurements: the radius of the wheel
  double slip = 0.0;         ///< for kSlip of every kSlipPeriod all are too fast by this fraction
  unsigned seed = 1;

  static constexpr double kLeastSigma = 0.01;  ///< [m/s]
  static constexpr double kSlip = 1.0;         ///< [s]
  static constexpr double kSlipPeriod = 2.5;   ///< [s]
};

/// A sensor half a metre behind and 0.3 m below the body, x along the optical axis, y to the left.
SpeedSensor simulatedSpeedSensor(const Calibration& calibration);

/// Forward speeds of the origin of `sensor` at begin() + k / rate_hz over the whole trajectory,
/// with the standard deviation of their noise.
std::vector<SpeedSample> simulateSpeeds(const Trajectory& trajectory, const SpeedSensor& sensor,
                                        const SpeedSimulationOptions& options);

}  // namespace slim_init::simulation
