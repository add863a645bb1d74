// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A state propagated on by the IMU as it was measured, with what that costs in certainty.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <string>
#include <vector>

#include "slim_init/host_health/imu_screen.h"
#include "slim_init/state_prior.h"
#include "slim_init/types.h"

namespace slim_init::host_health {

/// The matrix S with S w = v x w for every w.
Eigen::Matrix3d skewOf(const Eigen::Vector3d& v);
/// Rotation by the angle |v| [rad] about v, and the vector v of a rotation.
Eigen::Matrix3d expOf(const Eigen::Vector3d& v);
Eigen::Vector3d logOf(const Eigen::Matrix3d& R);

/// The sample at `t` [s] on the line through two others of different times.
ImuSample between(const ImuSample& a, const ImuSample& b, double t);

/// Errors [theta, v, p, b_g, b_a], all in the world.
using PropagatedCovariance = Eigen::Matrix<double, 15, 15>;

/// A state at a timestamp, and its covariance.
struct PropagatedState {
  NavState state;
  PropagatedCovariance covariance = PropagatedCovariance::Zero();

  double positionSigma() const;  ///< of the worst axis [m]
  double velocitySigma() const;  ///< of the worst axis [m/s]
  double yawSigma() const;       ///< [rad]
};

/// What a host's state in flight is worth: it defines position and yaw of its frame, so these are
/// exact; velocity, tilt and biases are those of a sliding window.
PropagatedCovariance healthyCovariance();

/// As the initializer takes it.
StatePrior toStatePrior(const PropagatedState& propagated);

/// Carries `from` to time `t` [s] through `samples`, whose neighbours' difference is taken as noise
/// besides the calibration's: a glitch that was not discarded widens the result. Over `damage` the
/// error of the samples is constant, with the standard deviations of the damage. `t` must lie
/// within the samples, else false and a message in `error`, which is not null.
bool propagateState(const PropagatedState& from, double t, const std::deque<ImuSample>& samples,
                    const std::deque<ImuDamage>& damage, const Eigen::Vector3d& gravity_w,
                    const ImuNoise& noise, PropagatedState* result, std::string* error);

/// Standard deviations per axis of a preintegration over an interval, from damage alone.
struct ImuWidening {
  double sigma_p = 0.0;      ///< [m]
  double sigma_v = 0.0;      ///< [m/s]
  double sigma_theta = 0.0;  ///< [rad]
  bool damaged = false;
};

/// Widening of the interval from t_i to t_j [s]. Intervals of damage are independent of each other.
ImuWidening wideningOf(const std::deque<ImuDamage>& damage, double t_i, double t_j);

/// The samples from t_i to t_j, both ends interpolated. Empty where the samples do not cover it.
std::vector<ImuSample> samplesBetween(const std::deque<ImuSample>& samples, double t_i, double t_j);

}  // namespace slim_init::host_health
