// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A state carried on by the IMU as it was measured, with what that costs in certainty.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <string>
#include <vector>

#include "imu_screen.h"
#include "slim_init/state_prior.h"
#include "slim_init/types.h"

namespace slim_init::vins_adapter {

/// What a body may do while the IMU says nothing, standard deviations.
constexpr double kUnknownAccel = 3.0;  ///< [m/s^2]
constexpr double kUnknownGyro = 1.0;   ///< [rad/s]

/// The matrix S with S w = v x w for every w.
Eigen::Matrix3d skewOf(const Eigen::Vector3d& v);

/// Errors [theta, v, p, b_g, b_a], all in the world.
using CarryCovariance = Eigen::Matrix<double, 15, 15>;

/// A state at an instant, and its covariance.
struct CarriedState {
  NavState state;
  CarryCovariance covariance = CarryCovariance::Zero();

  double positionSigma() const;  ///< of the worst axis [m]
  double velocitySigma() const;  ///< of the worst axis [m/s]
  double yawSigma() const;       ///< [rad]
};

/// What a host's state in flight is worth: it defines position and yaw of its frame, so these are
/// exact; velocity, tilt and biases are those of a sliding window.
CarryCovariance healthyCovariance();

/// As the initializer takes it.
StatePrior toStatePrior(const CarriedState& carried);

/// Carries `from` to time `t` [s] through `samples`, whose neighbours' difference is taken as noise
/// besides the calibration's: a glitch that was not left out widens the result. Over `damage` the
/// body is believed to have gone on as before and after it, to within 3 m/s^2 and 1 rad/s. `t` must
/// lie within the samples, else false and a message in `error`, which is not null.
bool carryState(const CarriedState& from, double t, const std::deque<ImuSample>& samples,
                const std::deque<ImuDamage>& damage, const Eigen::Vector3d& gravity_w,
                const ImuNoise& noise, CarriedState* result, std::string* error);

/// The samples from t_i to t_j, both ends interpolated. Empty where the samples do not cover it.
std::vector<ImuSample> samplesBetween(const std::deque<ImuSample>& samples, double t_i, double t_j);

}  // namespace slim_init::vins_adapter
