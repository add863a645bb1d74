// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// First step of `slim` on a rig that may be off: gyroscope bias, pruned tracks, and a calibration
// that is near enough for everything after it to be linear (docs/derivation.md, 1 and 6.1).
#pragma once

#include <memory>
#include <string>

#include "priors/sensor_priors.h"
#include "rotation/robust_bias.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/work_budget.h"

namespace slim_init {

/// Outcome of the step.
struct RotationStage {
  /// The window through the calibration found, with rows compensated and without static tracks
  /// (SlimOptions::prune_tracks); the one handed in where that changed nothing (then it does not
  /// own it).
  std::shared_ptr<const InitWindow> window;
  int static_tracks = 0;  ///< point tracks that `window` lacks (withoutStaticTracks())
  /// `window` without the observations that contradict the bias (SlimOptions::prune_tracks): what
  /// everything after this step takes.
  std::shared_ptr<const InitWindow> tracks;
  RobustBias bias;
  /// Not empty where the extrinsic rotation was unknown and the motion does not determine it; then
  /// there is no bias.
  std::string message;
  /// Calibration of the window handed in, against that of `window`, and its standard deviations.
  RigPrior prior;
  int rounds = 0;  ///< 1 where noise and readout time were near enough
};

/// Whether a calibration that the rotations contradict is replaced. Kept is the one that a host has
/// flown with: its state is that of a body under it.
enum class GivenCalibration { kReplaced, kKept };

/// Estimates bias, extrinsic rotation and td under what is known of the calibration, and sees the
/// window through what was found. Where the residuals of the rotations say that readout or noise
/// are others, all of it again with those; wrong tracks are searched for in the last round.
/// `budget` counts the work; at kShareOfRotations of it no further start and no further round is
/// tried.
RotationStage estimateRotations(const InitWindow& window, const InitializerOptions& options,
                                WorkBudget* budget,
                                GivenCalibration given = GivenCalibration::kReplaced);

/// Sets bias and track noise, and reports on the tracks. False, with status and message set, where
/// there is no bias and none is known, or no calibration.
bool acceptRotations(const RotationStage& stage, bool bias_is_known, InitResult* result);

}  // namespace slim_init
