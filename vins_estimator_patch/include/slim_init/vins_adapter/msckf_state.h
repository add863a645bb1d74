// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// From our estimates to the state and the covariance with which a filter of OpenVINS' kind begins.
// The only place where its convention appears. Compiled into the host as well (openvins_glue.h),
// hence C++11, and only plain numbers.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace slim_init {

struct InitResult;

namespace vins_adapter {

/// The IMU state of OpenVINS at one time. Its global frame has z up as ours.
struct MsckfState {
  /// [s], camera clock with the host's own td: t_imu = timestamp + td. NaN: not set.
  double timestamp = std::numeric_limits<double>::quiet_NaN();
  /// q_GtoI (4), p_IinG (3) [m], v_IinG (3) [m/s], b_g (3) [rad/s], b_a (3) [m/s^2]. The quaternion
  /// is JPL's, x y z w; its numbers are those of the Hamilton quaternion from body to world.
  std::vector<double> value;
  /// 15 x 15, symmetric, of the error state [theta, p, v, b_g, b_a]. theta is JPL's left error of
  /// q_GtoI, R_GtoI = (I - [theta]x) R_GtoI_estimated, which is ours on the right of R_w_b.
  std::vector<double> covariance;

  bool empty() const { return value.empty(); }
};

/// The state of the newest keyframe of `result`, in a world in which its position is zero: position
/// and heading at that time are what the world is defined by, and therefore known. In their place
/// the covariance has standard deviations of kHeldPosition and kHeldHeading, since the filter
/// inverts it; everything else is transformed to that world. `td` [s]: the host's own, as in
/// Calibration. On an estimate without states or without a covariance returns false, leaves `state`
/// as it was and puts a message into `error` (may be null).
bool toMsckfState(const InitResult& result, double td, MsckfState* state, std::string* error);

/// [m] and [rad]: far below what the first updates add.
constexpr double kHeldPosition = 1e-3;
constexpr double kHeldHeading = 1e-3;

}  // namespace vins_adapter
}  // namespace slim_init
