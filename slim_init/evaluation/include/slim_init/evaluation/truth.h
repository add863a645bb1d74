// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What can be said about true velocities and biases of a recording that does not hold them, and the
// inertial data between two times.
#pragma once

#include <string>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::evaluation {

/// A stretch of inertial data over which gyro and accelerometer are taken as constant.
struct InertialStep {
  double dt = 0.0;        ///< [s]
  Eigen::Vector3d gyro;   ///< mean of both ends [rad/s]
  Eigen::Vector3d accel;  ///< mean of both ends [m/s^2]
};

/// Cuts [t0, t1] at the samples, interpolating linearly at both ends. Returns false when the
/// samples do not cover the interval or a step between them is longer than `max_gap_s`.
bool inertialSteps(const std::vector<ImuSample>& imu, double t0, double t1, double max_gap_s,
                   std::vector<InertialStep>* steps);

/// Mean gyroscope bias over a recording.
struct GyroBiasFit {
  bool ok = false;
  std::string message;  ///< one sentence: what was fitted, or why not
  Eigen::Vector3d bias = Eigen::Vector3d::Constant(kNotComputed);  ///< [rad/s]
  int spans = 0;                                                   ///< used in the last pass
  int spans_rejected = 0;                                          ///< discarded as outliers
  double rms_rad = kNotComputed;  ///< residual rotation per span, root mean square [rad]
};

/// Fits one constant gyroscope bias so that the integrated gyro reproduces the true rotations
/// between samples about a second apart (least squares, Gauss-Newton with the Jacobian of the
/// integrated rotation with respect to the bias). Both lists ascending in time.
GyroBiasFit fitGyroBias(const std::vector<ImuSample>& imu, const std::vector<NavState>& truth);

/// Fills v_w_b of every state from the positions: per axis the median of the velocities from sample
/// to sample within 0.03 s on either side (of the two nearest steps where samples are rarer). A
/// tracking system that takes up its target again moves it by centimetres from one sample to the
/// next; a difference quotient makes metres per second of that, the median does not. Steps longer
/// than 0.3 s take no part; a state without any step keeps NaN. Ascending in time.
void deriveVelocities(std::vector<NavState>* truth);

/// Index of the state nearest in time to t [s]; -1 when `states` is empty. Ascending in time.
int nearestState(const std::vector<NavState>& states, double t);

}  // namespace slim_init::evaluation
