// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Motion, IMU and image times of a sequence to be rendered.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "simulate.h"
#include "slim_init/simulation/trajectory.h"
#include "slim_init/types.h"

namespace slim_init::tools {

/// All times relative to t0_ns [s], all lists ascending and cut to what the images need.
struct SimulatedMotion {
  std::string name;
  std::int64_t t0_ns = 0;
  std::unique_ptr<simulation::Trajectory> trajectory;  ///< of the body, IMU clock
  std::vector<double> image_times;                     ///< camera clock
  std::vector<ImuSample> imu;
  std::vector<NavState> truth;     ///< all fields finite
  std::vector<std::string> notes;  ///< one message each
};

/// Reads or makes the motion that the options name. Throws a Failure that names file, line, value
/// or option.
SimulatedMotion loadSimulatedMotion(const SimulateOptions& options, const Calibration& calibration);

}  // namespace slim_init::tools
