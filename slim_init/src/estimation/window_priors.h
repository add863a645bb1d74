// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "estimation/rig_model.h"
#include "estimation/state_factor.h"

namespace slim_init {

/// What is known about the motion of a vehicle before any data (docs/derivation.md, 5.2):
/// independent Gaussians about zero, of each axis. In a window of a few tenths of a second the
/// images leave the scale to the accelerometer, which has hardly begun to see it; without this the
/// estimate may be at any speed.
struct MotionPrior {
  double speed_sigma = 2.0;         ///< of the velocity at the middle keyframe [m/s]
  double acceleration_sigma = 3.0;  ///< of the mean acceleration over the window [m/s^2]

  /// The keyframe whose velocity is meant, of `keyframes`.
  static int middle(int keyframes) { return keyframes / 2; }
};

/// What is known of a window beside its data.
struct WindowPriors {
  RigPrior rig = {RigError(), {0.0, 0.0, 0.0, 0.0}};  ///< unless given, the calibration is exact
  std::optional<MotionPrior> motion = std::nullopt;
  /// In place of the priors of the biases.
  std::optional<StateFactor> known = std::nullopt;
};

}  // namespace slim_init
