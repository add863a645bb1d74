// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Starting point of the refinement: a linear solution with known rotations.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "scale/linear_motion.h"
#include "shape/ligt.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// The reverse alignment, positions from the visual shape; none where it fails. `pre` at the
/// gyroscope bias of the start, with derivatives; `translation` valid, in the frame of the first
/// camera.
std::optional<WindowState> startingState(const InitWindow& window,
                                         const std::vector<Preintegration>& pre,
                                         const TranslationEstimate& translation,
                                         const InertialOptions& inertial);

/// The inertial trajectory in whose centres the views of the tracks meet best, or none where that
/// is singular (docs/derivation.md, 3.3). It needs no shape, which fast turns over few common
/// tracks do not leave; the noise of the tracks makes it too small, so that it is no start for all
/// windows.
std::optional<WindowState> inertialStartingState(const InitWindow& window,
                                                 const std::vector<Preintegration>& pre,
                                                 const InertialOptions& inertial);

}  // namespace slim_init
