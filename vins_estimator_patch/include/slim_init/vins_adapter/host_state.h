// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// States under the host's names. Compiled into the host as well (host_glue.h), hence C++11, and
// only Eigen types without alignment.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

namespace slim_init {
namespace vins_adapter {

/// The state of one frame under the host's names. Its world has z up as ours, so poses and
/// velocities are the same numbers; names are those of the host.
struct HostState {
  /// Headers [s], camera clock; NaN: not set.
  double stamp = std::numeric_limits<double>::quiet_NaN();
  Eigen::Vector3d P = Eigen::Vector3d::Zero();      ///< Ps: body position in the world [m]
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< Rs: body to world
  Eigen::Vector3d V = Eigen::Vector3d::Zero();      ///< Vs: velocity in the world [m/s]
  Eigen::Vector3d Ba = Eigen::Vector3d::Zero();     ///< Bas: accelerometer bias [m/s^2]
  Eigen::Vector3d Bg = Eigen::Vector3d::Zero();     ///< Bgs: gyroscope bias [rad/s]
};

/// A window in the host's convention.
struct HostWindow {
  /// The host's `G`: what an accelerometer at rest reads, (0, 0, +g). Ours is the acceleration of
  /// free fall, (0, 0, -g); only this sign differs between the two conventions. NaN: not set.
  Eigen::Vector3d G = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  std::vector<HostState> states;
  /// Root of the information about the first state, row by row, kPriorColumns columns for the
  /// errors [P, theta to the right of R, V, Ba, Bg] of states.front(); empty: none. Position and
  /// heading are free.
  std::vector<double> prior;
  static constexpr int kPriorColumns = 15;
};

/// What an IMU measured from one frame of a host to the next, without what it cannot have felt.
struct HostImuInterval {
  /// The host's own samples hold a glitch, or are missing: these are to take their place.
  bool damaged = false;
  std::vector<double> dt;              ///< since the sample before [s]; the first is zero
  std::vector<Eigen::Vector3d> accel;  ///< specific force [m/s^2], both ends interpolated
  std::vector<Eigen::Vector3d> gyro;   ///< angular rate [rad/s]
  /// What is not known because samples are missing, standard deviation per axis.
  double sigma_theta = 0.0;  ///< [rad]
  double sigma_v = 0.0;      ///< [m/s]
  double sigma_p = 0.0;      ///< [m]
};

/// What the newest frame of a host in flight needs before its optimization
/// (HostAdapter::prepare()).
struct HostPreparation {
  /// The intervals between the frames of the window, one less than frames; empty if the buffer does
  /// not cover them. Only the damaged ones are to be replaced.
  std::vector<HostImuInterval> intervals;
  bool replaces_newest = false;  ///< `newest` is better than the host's own prediction
  HostState newest;
  std::vector<long long> moving;  ///< ids of tracks that move against the scene
  bool suspect = false;  ///< images and IMU contradict each other, or all of the image moves
  /// By how much the odometry frame may have moved and turned in the newest interval because images
  /// and IMU did not both support the host there; zero: they did.
  double position_sigma = 0.0;  ///< [m]
  double yaw_sigma_deg = 0.0;   ///< [deg]
  std::string message;          ///< what was found, with values and limits; "": nothing
};

}  // namespace vins_adapter
}  // namespace slim_init
