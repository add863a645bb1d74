// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// An answer in the frame of an earlier estimate.
#pragma once

#include "slim_init/result.h"
#include "slim_init/types.h"

namespace slim_init {

/// Moves `result` so that `here`, the body in its world, agrees with `there`, the body at the same
/// instant in another gravity-aligned world, in position and in heading. Roll and pitch stay: they
/// come from gravity.
void moveToFrame(const NavState& there, const NavState& here, InitResult* result);

}  // namespace slim_init
