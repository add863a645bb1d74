// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "estimation/motion_prior.h"
#include "estimation/rig_model.h"
#include "estimation/state_factor.h"

namespace slim_init {

/// What is known of a window beside its data.
struct WindowPriors {
  RigPrior rig = {RigError(), {0.0, 0.0, 0.0, 0.0}};  ///< unless given, the calibration is exact
  std::optional<MotionPrior> motion = std::nullopt;
  /// In place of the priors of the biases.
  std::optional<StateFactor> known = std::nullopt;
};

}  // namespace slim_init
