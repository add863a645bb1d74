// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Where evaluation and simulation meet: a sequence out of a recording or a built-in motion.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ab_options.h"
#include "slim_init/evaluation/sequence.h"
#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/types.h"

namespace slim_init::tools {

struct LoadedSequence {
  evaluation::Sequence sequence;
  std::string gyro_bias_truth;  ///< "recorded", "fitted", "simulated" or "none"
  std::optional<simulation::FeatureSimulationCounts> simulated;  ///< of simulated features
};

/// Fills loaded->sequence.truth at `times` (camera clock) from the ground truth of a recording,
/// ascending in time: pose and velocity interpolated, biases those of the nearest state. Without
/// biases in the truth one gyroscope bias is fitted to sequence.imu. Where the truth has a gap, t
/// is NaN; without any truth the sequence has none. `source` names the recording in a sentence.
std::string addTruth(std::vector<NavState> truth, bool has_bias, const std::string& source,
                     const std::vector<double>& times, LoadedSequence* loaded);

/// Empties sequence->speeds, with a note, where the calibration lacks the sensor.
void discardUncalibratedSpeeds(evaluation::Sequence* sequence);

/// Reads --recorded or simulates --builtin and projects the world at the image times, or tracks
/// through the images of --asl or --bag. Returns an empty string, or a sentence naming file, line,
/// value or option.
std::string loadSequence(const AbOptions& options, LoadedSequence* loaded);

}  // namespace slim_init::tools
