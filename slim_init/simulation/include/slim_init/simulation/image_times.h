// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// When a camera takes its images.
#pragma once

#include <vector>

namespace slim_init::simulation {

/// Times of a camera whose automatic exposure sets its rate, from `first` to `last` [s]: 33, 40 or
/// 60 ms apart for half a second to two seconds each, with a gap of 0.4 s about every six seconds.
/// Equal seeds give equal times.
std::vector<double> autoExposureTimes(double first, double last, unsigned seed);

}  // namespace slim_init::simulation
