// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// An estimate at other times than its keyframes.
#pragma once

#include <string>
#include <vector>

#include "slim_init/result.h"
#include "slim_init/types.h"

namespace slim_init {

/// How far statesAt() may rely on the IMU alone.
struct StateAtOptions {
  double max_reach_s = 1.0;     ///< before the first and after the last keyframe [s]
  double max_imu_gap_s = 0.05;  ///< [s] a longer gap between the samples in use is refused
};

/// The states at `times` [s, IMU clock], propagated there by the IMU at the biases of the
/// keyframes: between two keyframes from both, weighted by nearness; outside them forward from the
/// last or backward from the first. Of `result` states (ascending in time), gravity_w and
/// at_rest_since are read: while the body stood still no IMU data are needed, and no reach is too
/// long. `imu` ascends. On bad input (no keyframe, a time that is not finite, out of
/// reach or not covered by the IMU, a gap) returns false, leaves `states` as it was and puts a
/// message with value and bound into `error` (may be null).
bool statesAt(const InitResult& result, const std::vector<ImuSample>& imu,
              const std::vector<double>& times, const StateAtOptions& options,
              std::vector<NavState>* states, std::string* error);

}  // namespace slim_init
