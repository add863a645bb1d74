// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Are a host's newest states right? Its own failure detection does not notice most failures.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <string>
#include <vector>

#include "imu_carry.h"
#include "imu_screen.h"
#include "slim_init/types.h"

namespace slim_init::vins_adapter {

/// What the watchdog measured in one window of a host, and its verdict.
struct WatchFinding {
  bool sane = true;
  std::string reason;  ///< what is wrong, with value and bound; empty while sane
  /// Of tracks triangulated between the window's older poses and seen again in the newest [px];
  /// NaN: too few.
  double reprojection_px = kNotComputed;
  /// Of the newest state from an older one of the window, carried there by the IMU; NaN: not
  /// compared.
  double velocity_mps = kNotComputed;
  double rotation_deg = kNotComputed;
};

/// Bounds of the watchdog.
struct WatchBounds {
  double reprojection_px = 6.0;  ///< median over the tracks
  int tracks = 10;               ///< fewer are not judged
  double velocity_mps = 0.5;     ///< besides three standard deviations of the IMU
  double rotation_deg = 3.0;     ///< likewise
  double gyro_bias = 0.5;        ///< [rad/s]
  double accel_bias = 2.0;       ///< [m/s^2]
};

/// Judges a window of a host by data that the host did not choose: `states` on the IMU clock, one
/// per frame, ascending; `frames` with their stamps on the IMU clock (those that have none are
/// skipped); the usable IMU samples and the intervals without. `calibration` is the one that the
/// host works with.
WatchFinding watchWindow(const std::vector<NavState>& states,
                         const std::vector<FrameObservation>& frames,
                         const std::deque<ImuSample>& samples, const std::deque<ImuDamage>& damage,
                         const Calibration& calibration, const WatchBounds& bounds = {});

/// Compares a host's newest state to an answer of the initializer carried to the same instant.
/// `scale_sigma` is the relative standard deviation of the answer's scale. Returns a reason, or "".
std::string compareStates(const NavState& host, const NavState& answer, double scale_sigma);

}  // namespace slim_init::vins_adapter
