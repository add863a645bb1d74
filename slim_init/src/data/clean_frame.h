// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "slim_init/stream_check.h"
#include "slim_init/types.h"

namespace slim_init {

/// Below this angle between its end points a segment has no usable direction [rad].
inline constexpr double kMinLineAngle = 1e-6;

/// Sorts points and lines by id, makes bearings unit vectors, and drops what no solver can use:
/// values that are not finite, zero bearings, the second use of an id, lines whose end points
/// coincide. Of several observations with one id the first stays. Every drop is counted. Applying
/// it twice changes nothing.
void cleanFrame(FrameObservation& frame, StreamCounts& counts);

/// The same for lines that come after their frame.
void cleanLines(std::vector<LineObservation>& lines, StreamCounts& counts);

}  // namespace slim_init
