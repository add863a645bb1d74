// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rotations that the points of a keyframe pair measure alone, for the check of the calibration
// (docs/derivation.md, 6.1).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rotation/constants.h"
#include "rotation/keyframe_pairs.h"
#include "rotation/rotation_correction.h"

namespace slim_init {

/// The pairs `gap` keyframes apart with their rotation freed from that of the gyroscope,
/// `rotations` at the bias. A schedule that begins with tens of standard deviations finds rotations
/// that are degrees off. Pairs whose points do not determine a rotation are left out. All points
/// take part, whatever the pruning says.
std::vector<RotationCorrection> freeRotations(const KeyframePairs& pairs,
                                              const PairRotations& rotations,
                                              const Baselines& baselines, int gap,
                                              const CutoffSchedule& schedule);

}  // namespace slim_init
