// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Where evaluation and simulation meet: a sequence out of a recording or a built-in motion.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ab_options.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence.h"
#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/types.h"

namespace slim_init::tools {

struct LoadedSequence {
  evaluation::Sequence sequence;
  std::string gyro_bias_truth;  ///< "recorded", "fitted", "simulated" or "none"
  std::optional<simulation::FeatureSimulationCounts> simulated;  ///< of simulated features
};

/// The EuRoC rig (Burri et al. 2016): left camera and ADIS16448 IMU. Recordings of --recorded and
/// the built-in motions use it alike.
Calibration eurocCalibration();

/// evaluation::openAslFolder() and openRosbag(); throw a Failure.
std::unique_ptr<evaluation::ImageSequence> openAsl(const std::string& folder, double max_imu_gap_s);
std::unique_ptr<evaluation::ImageSequence> openBag(const std::string& file,
                                                   const evaluation::BagTopics& topics,
                                                   const std::string& truth, double max_imu_gap_s);
/// Those of IMU and images in the host's file.
evaluation::BagTopics topicsOf(const Config& config);

/// Without --config: camera and calibration that lie beside the data, and the keys of --options on
/// top (`options_file`, may be empty). `source`: the recording as the user named it. Throws a
/// Failure that names what is missing or wrong.
void configureFromData(const std::string& source, const std::string& options_file, Config* config);

/// Reads --recorded or simulates --builtin and projects the world at the image times, or tracks
/// through the images of --asl or --bag. Throws a Failure that names file, line, value or option.
LoadedSequence loadSequence(const AbOptions& options);

}  // namespace slim_init::tools
