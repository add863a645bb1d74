// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What an answer knows of one of the host's states, as a factor for the host's optimization.
#pragma once

#include <vector>

#include "slim_init/host_health/imu_propagation.h"
#include "slim_init/result.h"
#include "slim_init/types.h"
#include "slim_init/vins_adapter/host_state.h"

namespace slim_init::vins_adapter {

/// HostWindow::prior of a state: `at` is the state in the world of `answer` (statesAt()), `host`
/// the same in the host's. Velocity in the body, direction of gravity and biases, with the
/// covariance of the nearest keyframe; position and heading are free. Empty where the answer has no
/// covariance.
std::vector<double> firstStatePrior(const InitResult& answer, const NavState& at,
                                    const HostState& host);

/// The same of a state that the host has had itself.
std::vector<double> firstStatePrior(const host_health::PropagatedState& healthy,
                                    const HostState& host);

}  // namespace slim_init::vins_adapter
