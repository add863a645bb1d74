// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Recorded and built-in motions with their IMU, before anything is seen along them: for `ab` and
// `simulate`.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/evaluation/recorded.h"
#include "slim_init/simulation/trajectory.h"
#include "slim_init/types.h"

namespace slim_init::tools {

/// A fitted gyro bias has no accelerometer bias beside it in the ground truth: NaN. Images that IMU
/// and trajectory do not cover may be among the image times until discardUncovered().
struct Motion : evaluation::RecordedMotion {
  std::unique_ptr<simulation::Trajectory> trajectory;  ///< of the body, IMU clock
  std::string gyro_bias_truth;                         ///< "recorded", "fitted" or "simulated"
};

/// Without biases in a recorded ground truth one gyroscope bias is fitted to `imu` and noted.
/// Returns Motion::gyro_bias_truth; throws a Failure that begins with `source`.
std::string settleBiases(bool has_bias, const std::string& source,
                         const std::vector<ImuSample>& imu, std::vector<NavState>* truth,
                         std::vector<std::string>* notes);

/// Reads a folder of --recorded. Throws a Failure that names file, line or value.
Motion recordedMotion(const std::string& folder, double max_imu_gap_s);

/// A motion of --builtin, without IMU. Throws a Failure.
Motion builtinMotion(const std::string& name, double duration_s, const Calibration& calibration,
                     unsigned seed);

/// Simulates IMU, ground truth and image times along the trajectory. There are images from
/// `margin_s` after its begin to as long before the last IMU sample.
void simulateSensors(const Calibration& calibration, double imu_rate_hz, double image_rate_hz,
                     double margin_s, unsigned seed, Motion* motion);

/// Discards the images outside the IMU data and those at which the trajectory is not known, with a
/// note; `td` to the IMU clock. Throws a Failure where none is left.
void discardUncovered(double td, Motion* motion);

}  // namespace slim_init::tools
