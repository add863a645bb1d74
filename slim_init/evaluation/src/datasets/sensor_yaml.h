// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The sensor.yaml files of an ASL folder.
#pragma once

#include <string>

#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence_writer.h"

namespace slim_init::evaluation {

/// Reads cam0/sensor.yaml (T_BS, resolution, camera_model, intrinsics, distortion_model,
/// distortion_coefficients) and imu0/sensor.yaml (T_BS, noise densities). Returns an empty string,
/// or a sentence naming file, key and value; then `calibration` is as it was.
std::string readSensorYaml(const std::string& camera_file, const std::string& imu_file,
                           SequenceCalibration* calibration);

/// The same files as text.
std::string cameraSensorYaml(const WriterRig& rig);
std::string imuSensorYaml(const WriterRig& rig);

}  // namespace slim_init::evaluation
