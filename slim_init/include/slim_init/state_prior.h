// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is known of the body and of its sensors before the data of a window.
#pragma once

#include <Eigen/Core>
#include <string>

#include "slim_init/result.h"
#include "slim_init/types.h"

namespace slim_init {

/// A state that is known from elsewhere, with its covariance: the last one of an estimator before
/// it failed, or that of a body at rest.
struct StatePrior {
  /// In a gravity-aligned world w of any origin and heading, z up; time on the IMU clock.
  NavState state;
  /// Of the errors [theta, p, v, b_g, b_a]: theta on the right of R_w_b [rad], p [m] and v [m/s] in
  /// w, b_g [rad/s], b_a [m/s^2], each the ground truth minus the estimate; the order of
  /// InitResult::covariance. Position and heading may be exact (zero): they define w. The rest has
  /// to be positive definite.
  Eigen::Matrix<double, 15, 15> covariance = Eigen::Matrix<double, 15, 15>::Zero();
  /// Extrinsics that the estimator has found, in place of those that the initializer was given; td
  /// comes through IInitializer::setTd(), and the readout time stays as it is.
  OptionalCalibration calibration;
  /// The body stands there: a start, whose scale has to be known. A state in flight vouches for
  /// velocity and attitude, with which an estimator goes on.
  bool at_rest = false;

  /// Returns an empty string, or a message naming what is not finite, not a rotation, or no
  /// covariance.
  std::string validate() const;
};

/// Sensor knowledge from before a restart: a warm start. The state of the body is not known.
struct KnownSensors {
  ImuBiases biases;
  /// In place of what the initializer was given, each part within its covariance: rotation,
  /// translation, and td where that has a variance. The readout time stays as it is.
  OptionalCalibration calibration;

  /// Nothing is known.
  bool empty() const;
  /// Returns an empty string, or a message naming what is out of bounds, not finite or no rotation.
  std::string validate() const;
};

/// What is known before the data of a window; empty: nothing.
struct Priors {
  /// States of a host from before its failure, ascending in time, within the buffered IMU data.
  std::vector<StatePrior> healthy = {};
  /// Where the data contradict the biases, these are not used, and InitResult::warnings says so.
  /// Ignored if KnownSensors::validate() refuses it.
  KnownSensors sensors = {};
};

}  // namespace slim_init
