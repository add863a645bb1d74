// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Units of options and messages in those of the equations.
#pragma once

#include <cmath>

namespace slim_init {

inline constexpr double kDegPerRad = 180.0 / M_PI;
// A twentieth of a pixel [rad]: no image shows less, and no tracker is better.
inline constexpr double kSmallestAngle = 1e-4;
inline constexpr double kPerMilli = 1e3;  // ms in a second, mm in a metre, us in a millisecond

}  // namespace slim_init
