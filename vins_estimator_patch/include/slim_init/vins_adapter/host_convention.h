// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// From our states to those of a VINS-Mono style host. The only place where the host's convention
// appears.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slim_init/types.h"
#include "slim_init/vins_adapter/host_state.h"

namespace slim_init::vins_adapter {

/// Where the world frame of the host's window lies.
enum class HostOrigin {
  /// A first start: the first body position is zero, the first yaw is zero, as the host's own
  /// initialization leaves it.
  kFirstBody,
  /// After a recovery: the states are already in the host's old odometry frame and stay in it.
  kKeep,
};

/// Stamps of the frames of a window [s].
std::vector<double> stampsOf(const std::vector<HostState>& window);

/// Yaw of a rotation as the host takes it [rad]: the direction of the body's x axis in the ground
/// plane; zero where that axis is vertical and the yaw therefore not defined.
double hostYaw(const Eigen::Matrix3d& R_w_b);

/// Converts states of our world (z up, gravity (0, 0, -gravity_magnitude)). `td` as in
/// Calibration: host stamp = t - td [s]. On bad input (no state, a value that is not finite, a
/// matrix that is not a rotation, times that do not ascend, gravity_magnitude not positive)
/// returns false, leaves `window` as it was and puts a message into `error` (may be null).
bool toHostWindow(const std::vector<NavState>& states, double gravity_magnitude, double td,
                  HostOrigin origin, HostWindow* window, std::string* error);

/// The rotation about z that brings `from` closest to `to`: the twist about z of their difference.
/// Unlike a difference of Euler yaws it is well defined for every mounting. False, and `turn` as it
/// was, where the difference tilts by 180 deg.
bool turnAboutVertical(const Eigen::Matrix3d& to, const Eigen::Matrix3d& from,
                       Eigen::Matrix3d* turn);

/// Moves a window, which has a state, so that its first frame has the position and the heading of
/// `anchor`.
void moveWindow(const HostState& anchor, HostWindow* window);

/// Tracked points of camera 0 as a host passes them, six numbers each: id, x, y, z (undistorted,
/// z = 1), u, v [px].
FrameObservation toFrame(double stamp, const std::vector<double>& points);

/// One state, in the world it is in: the same values under the host's names, stamp = t - td [s].
HostState toHostState(const NavState& state, double td);

/// The inverse, for the last healthy state of a host.
NavState fromHostState(const HostState& state, double td);

}  // namespace slim_init::vins_adapter
