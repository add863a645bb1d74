// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slim_init/init_window.h"

namespace slim_init {

/// Sorts points and lines by id, makes bearings unit vectors, and drops what no solver can use:
/// values that are not finite, zero bearings, the second use of an id, lines whose end points
/// coincide. Of several observations with one id the first handed in stays. Every drop is counted.
/// Applying it twice changes nothing.
void cleanFrame(FrameObservation& frame, WindowCounts& counts);

}  // namespace slim_init
