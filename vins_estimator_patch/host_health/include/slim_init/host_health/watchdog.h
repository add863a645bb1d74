// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Whether a host's newest states are correct: its own failure detection does not notice most
// failures.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <string>
#include <vector>

#include "slim_init/host_health/flight_monitor.h"
#include "slim_init/host_health/imu_propagation.h"
#include "slim_init/host_health/imu_screen.h"
#include "slim_init/types.h"

namespace slim_init::host_health {

/// Judges a window of a host by data that the host did not choose: `states` on the IMU clock, one
/// per frame, ascending; `frames` with their stamps on the IMU clock (those that have none are
/// skipped); the usable IMU samples and the intervals without. `calibration` is the one that the
/// host works with. A check that fails makes it suspect.
HostHealth watchWindow(const std::vector<NavState>& states,
                       const std::vector<FrameObservation>& frames,
                       const std::deque<ImuSample>& samples, const std::deque<ImuDamage>& damage,
                       const Calibration& calibration);

/// Biases do not jump. An optimization that has been thrown off and finds back to the tracks has
/// put its error into them, and in hover nothing but their past says so. VINS-Mono's settle by
/// up to 0.2 m/s^2 and 6e-3 rad/s in the first seconds after a start (V1_01, V1_02, V2_01, MH_04);
/// in hover an incorrect state left 2 to 3 m/s^2 behind.
class SteadyBiases {
 public:
  static constexpr double kAccelStep = 0.5;  ///< [m/s^2], from the mean of before
  static constexpr double kGyroStep = 0.1;   ///< [rad/s]
  static constexpr double kMemory = 5.0;     ///< [s], of that mean

  /// A reason, or "" where `state`, which is finite, goes on as before; it then counts.
  std::string judge(const NavState& state);

 private:
  double newest_ = kNotComputed;  // time of the last state that counts [s]
  Eigen::Vector3d accel_bias_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();
};

/// Compares a host's newest state to an estimate of the initializer, propagated to the same
/// timestamp. `scale_sigma` is the relative standard deviation of the estimate's scale,
/// `tilt_sigma_deg` that of its direction of gravity. Returns a reason, or "".
std::string compareStates(const NavState& host, const NavState& answer, double scale_sigma,
                          double tilt_sigma_deg = 0.0);

}  // namespace slim_init::host_health
