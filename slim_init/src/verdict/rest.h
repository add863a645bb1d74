// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Whether the body stands still, as images and IMU say together, and what is known then.
#pragma once

#include <Eigen/Core>

#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/state_prior.h"

namespace slim_init {

/// Shortest rest [s]; one of twice that is looked for as well. And time over which IMU samples are
/// averaged to see motion [s]: the vibration of an idling engine is gone in it.
inline constexpr double kRestSpan = 1.0;
inline constexpr double kRestStep = 0.3;

/// How much a window moves, each in units of its own measured noise: about 1 for a body that stands
/// on firm ground. NaN where it could not be measured, which is no rest.
struct RestMeasures {
  double span = kNotComputed;  ///< of the window [s]
  /// Median over the tracks of the distance between the mean bearings of their first and last
  /// thirds, without any compensation of a rotation.
  double tracks = kNotComputed;
  /// What of that distance is not noise, over its time [rad/s]: so much the body turns all the
  /// same.
  double turn_rate = 0.0;
  int track_count = 0;          ///< tracks behind it
  double rate = kNotComputed;   ///< rms deviation of the angular rate, averaged over kRestStep
  double force = kNotComputed;  ///< the same of the specific force
  Eigen::Vector3d mean_rate = Eigen::Vector3d::Zero();   ///< in b [rad/s]
  Eigen::Vector3d mean_force = Eigen::Vector3d::Zero();  ///< in b [m/s^2]
  double rate_sigma = kNotComputed;   ///< standard deviation of an axis of mean_rate [rad/s]
  double force_sigma = kNotComputed;  ///< the same of mean_force [m/s^2]

  /// Nothing moves by much more than noise, and the rest is what a body at rest measures: gravity,
  /// and a rate within the prior of the gyroscope bias.
  bool isRest(double gravity_magnitude, const InertialOptions& inertial) const;
};

/// Measures a window of every image, kRestSpan or longer. An elevator at constant speed, seen from
/// inside, measures as rest.
RestMeasures measureRest(const InitWindow& window);

/// The state of a body at rest at time `t` [s]: origin there, heading of the body's x axis zero;
/// velocity zero, tilt and accelerometer bias so that they explain the mean specific force together
/// (docs/derivation.md, 5.5), gyroscope bias the mean rate. `known`: biases known from before.
StatePrior priorAtRest(const RestMeasures& rest, double t, double gravity_magnitude,
                       const ImuBiases& known, const InertialOptions& inertial);

}  // namespace slim_init
