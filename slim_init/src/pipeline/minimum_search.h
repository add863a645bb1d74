// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The search of the minimum around refineWindow(): which lines are believed and which starts are
// tried (docs/derivation.md, 4.8 and 4.9).
#pragma once

#include <vector>

#include "estimation/posterior.h"
#include "estimation/refine_window.h"
#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "lines/line_track.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"

namespace slim_init {

/// The line tracks that agree with `start`; all of them where lines are not pruned or not used.
std::vector<Track> believedLines(const InitWindow& tracks, const WindowState& start,
                                 const InitializerOptions& options);

/// Maximum a posteriori estimate from `start`. `again`: a second search follows if the first
/// minimum looks wrong, within the budget.
RefinedWindow searchMinimum(const RefinementInput& input, const std::vector<Track>& lines,
                            const WindowState& start, bool again);

/// Posterior of a refined window, of the rig as well where that was estimated.
Posterior posteriorOf(const InitWindow& tracks, const RefinedWindow& refined);

}  // namespace slim_init
