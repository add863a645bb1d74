// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Which stretches of the line tracks show one line in space. A line that the tracker confuses with
// another stays confused for the rest of its track; a robust loss alone does not help against it,
// since with a jump in the middle neither half is the outlier.
#pragma once

#include <vector>

#include "imu/window_state.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// Line tracks cut into stretches of consecutive observations in which a single line explains every
/// end point to within `max_error_rad`, seen from the cameras of `motion`; the longest stretch
/// first, then what is left on both sides of it. Stretches shorter than `min_views` are left out.
///
/// Only rotations and the shape of the trajectory matter, not its scale. Two views always agree
/// (they put no constraint on the motion, docs/derivation.md), so the test begins with the third.
/// Returned are ranges of InitWindow::lineObservations(); ids repeat after a cut.
std::vector<Track> agreeingLineTracks(const InitWindow& window, const WindowState& motion,
                                      double max_error_rad, int min_views);

}  // namespace slim_init
