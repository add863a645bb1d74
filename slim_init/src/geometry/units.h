// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Units of options and messages in those of the equations.
#pragma once

#include <cmath>

namespace slim_init {

inline constexpr double kDegPerRad = 180.0 / M_PI;
inline constexpr double kMsPerS = 1e3;
inline constexpr double kMmPerM = 1e3;

}  // namespace slim_init
