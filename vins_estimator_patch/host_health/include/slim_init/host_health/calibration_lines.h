// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A calibration that was found, as lines of the host's file.
#pragma once

#include <string>

#include "slim_init/result.h"
#include "slim_init/types.h"

namespace slim_init::host_health {

/// What the host's file says about the rig, to compare it with what was found.
struct FileCalibration {
  Calibration calibration;
  bool extrinsic_in_one_matrix = false;  ///< body_T_cam0, as VINS-Fusion has it
  bool has_rotation = true;
  bool has_translation = true;
};

/// The keys of the host's file that `found` contradicts by more than two of its standard
/// deviations and by so much that it matters to a host (td 3 ms, readout 5 ms, rotation 1 deg,
/// translation 20 mm), and those of an extrinsic that the file does not have, with their new
/// values: lines to paste, each key under a comment with the standard deviation. Empty where there
/// are none.
std::string calibrationLines(const FileCalibration& file, const CalibrationEstimate& found);

}  // namespace slim_init::host_health
