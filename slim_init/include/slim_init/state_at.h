// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// An estimate at other times than its keyframes.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slim_init/types.h"

namespace slim_init {

/// How far statesAt() may rely on the IMU alone.
struct StateAtOptions {
  double max_reach_s = 1.0;     ///< before the first and after the last keyframe [s]
  double max_imu_gap_s = 0.05;  ///< [s] a longer gap between the samples in use is refused
  /// The body stood still from here to the first keyframe [s]: no IMU data are needed there, and no
  /// reach is too long. NaN: it did not.
  double at_rest_since = kNotComputed;
};

/// The states at `times` [s, IMU clock], propagated there by the IMU at the biases of the
/// keyframes: between two keyframes from both, weighted by nearness; outside them forward from the
/// last or backward from the first. `keyframes` ascend in time, `imu` ascends, `gravity_w` [m/s^2]
/// belongs to the keyframes' world. On bad input (no keyframe, a time that is not finite, out of
/// reach or not covered by the IMU, a gap) returns false, leaves `states` as it was and puts a
/// message with value and bound into `error` (may be null).
bool statesAt(const std::vector<NavState>& keyframes, const Eigen::Vector3d& gravity_w,
              const std::vector<ImuSample>& imu, const std::vector<double>& times,
              const StateAtOptions& options, std::vector<NavState>* states, std::string* error);

}  // namespace slim_init
