// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A solve of a window at whose first keyframe the state of the body is known
// (docs/derivation.md, 5.3).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "estimation/refine_window.h"
#include "estimation/state_factor.h"
#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "slim_init/init_window.h"
#include "slim_init/result.h"
#include "slim_init/state_prior.h"

namespace slim_init {

/// The window through the extrinsics that the state brings, and its td if the body has stood; null,
/// with kInvalidInput and a message, where they cannot be solved together.
std::shared_ptr<const InitWindow> windowOfState(const InitWindow& window, const StatePrior& prior,
                                                InitResult* result);

/// The motion of a window as the IMU alone continues the known state, at whose biases `pre` is.
WindowState deadReckoned(const StateFactor& known, const std::vector<Preintegration>& pre,
                         double gravity_magnitude);

/// The part of the known state `known` that the data contradict most, or "": none, or one of those
/// in `dropped`, so that what is left is not this state's fault. From then on it is as good as
/// unknown. `residual`: estimate minus state.
std::string dropContradicted(const InitWindow& tracks, const RefinedWindow& refined,
                             const std::vector<std::string>& dropped, StateFactor* known,
                             StateVector* residual);

/// Moves the result into the world of the state, whose pose the window corrects as far as its error
/// correlates with those of velocity, tilt and biases. `residual` as dropContradicted() gave it.
void moveToWorldOf(const StatePrior& prior, const StateVector& residual, InitResult* result);

}  // namespace slim_init
