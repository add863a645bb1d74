// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is known about the motion of a vehicle before any data (docs/derivation.md, 5.2). In a
// window of a few tenths of a second the images leave the scale to the accelerometer, which has
// hardly begun to see it; without this the estimate may be at any speed.
#pragma once

#include <Eigen/Core>

#include "imu/window_state.h"

namespace slim_init {

/// Independent Gaussians about zero, of each axis.
struct MotionPrior {
  double speed_sigma = 2.0;         ///< of the velocity at the middle keyframe [m/s]
  double acceleration_sigma = 3.0;  ///< of the mean acceleration over the window [m/s^2]

  /// The keyframe whose velocity is meant, of `keyframes`.
  static int middle(int keyframes) { return keyframes / 2; }
};

/// Whitened residual [middle velocity, change of the velocity], with its derivatives by the
/// velocities of first, middle and last keyframe.
struct MotionResidual {
  Eigen::Matrix<double, 6, 1> r;
  Eigen::Matrix<double, 6, 9> J;
};

/// Evaluates the prior at a state of at least three keyframes that spans `duration` [s].
MotionResidual motionResidual(const WindowState& state, const MotionPrior& prior, double duration);

}  // namespace slim_init
