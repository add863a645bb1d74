// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// From our states to those of a VINS-Mono style host. The only place where the host's convention
// appears.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::vins_adapter {

/// Where the world frame of the host's window lies.
enum class HostOrigin {
  /// A first start: the first body position is zero, the first yaw is zero, as the host's own
  /// initialization leaves it.
  kFirstBody,
  /// After a recovery: the states are already in the host's old odometry frame and stay in it.
  kKeep,
};

/// The state of one frame under the host's names. Its world has z up as ours, so poses and
/// velocities are the same numbers; names say what the host calls them.
struct HostState {
  double stamp = kNotComputed;                      ///< Headers [s], camera clock
  Eigen::Vector3d P = Eigen::Vector3d::Zero();      ///< Ps: body position in the world [m]
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< Rs: body to world
  Eigen::Vector3d V = Eigen::Vector3d::Zero();      ///< Vs: velocity in the world [m/s]
  Eigen::Vector3d Ba = Eigen::Vector3d::Zero();     ///< Bas: accelerometer bias [m/s^2]
  Eigen::Vector3d Bg = Eigen::Vector3d::Zero();     ///< Bgs: gyroscope bias [rad/s]
};

/// A window in the host's convention.
struct HostWindow {
  /// The host's `G`: what an accelerometer at rest reads, (0, 0, +g). Ours is the acceleration of
  /// free fall, (0, 0, -g); only this sign differs between the two conventions.
  Eigen::Vector3d G = Eigen::Vector3d::Constant(kNotComputed);
  std::vector<HostState> states;
};

/// Yaw of a rotation as the host takes it [rad]: the direction of the body's x axis in the ground
/// plane; zero where that axis is vertical and the yaw therefore not defined.
double hostYaw(const Eigen::Matrix3d& R_w_b);

/// Converts states of our world (z up, gravity (0, 0, -gravity_magnitude)). `td` as in
/// Calibration: host stamp = t - td [s]. On bad input (no state, a value that is not finite, a
/// matrix that is not a rotation, times that do not ascend, gravity_magnitude not positive)
/// returns false, leaves `window` as it was and puts a sentence into `error` (may be null).
bool toHostWindow(const std::vector<NavState>& states, double gravity_magnitude, double td,
                  HostOrigin origin, HostWindow* window, std::string* error);

/// The way back, for the last healthy state that a host hands over for a recovery. Same values,
/// our names; t = stamp + td [s].
NavState fromHostState(const HostState& state, double td);

}  // namespace slim_init::vins_adapter
