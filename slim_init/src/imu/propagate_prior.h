// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A known state carried on by the IMU, with its covariance.
#pragma once

#include <vector>

#include "slim_init/state_prior.h"
#include "slim_init/types.h"

namespace slim_init {

/// `prior` at time `t` [s], not before it. `samples` ascend and cover the time between; `noise` as
/// the data sheet has it, widened here to that of a sensor in motion (docs/derivation.md, 5.3).
StatePrior propagatePrior(const StatePrior& prior, double t, const std::vector<ImuSample>& samples,
                          double gravity_magnitude, const ImuNoise& noise);

}  // namespace slim_init
