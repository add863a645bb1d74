// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Sequences for the tests of the back end: a built-in motion with its IMU, seen by a front end.
#pragma once

#include <string>

#include "slim_init/evaluation/sequence.h"

namespace slim_init {

struct SimulatedSequenceOptions {
  std::string motion = "figure-eight";  ///< simulation::builtinTrajectoryNames()
  double duration_s = 20.0;
  unsigned seed = 1;
  double outlier_rate = 0.0;  ///< share of tracks that slide off
};

/// EuRoC's rig; truth at every frame, with the simulated biases. An unknown motion gives an empty
/// sequence.
evaluation::Sequence makeSimulatedSequence(const SimulatedSequenceOptions& options);

/// The truth at frame k.
inline NavState truthOfFrame(const evaluation::Sequence& sequence, std::size_t k) {
  return evaluation::truthAt(sequence, sequence.calibration.imuTime(sequence.frames[k].t));
}

}  // namespace slim_init
