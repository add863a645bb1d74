// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Measured velocities as factors of the estimate (docs/derivation.md, 5.6): each with a robust
// cost, under one relative error that all of them have in common (the radius of a wheel).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimation/inertial_factor.h"
#include "imu/window_state.h"
#include "slim_init/init_window.h"
#include "slim_init/result.h"

namespace slim_init {

/// The velocity of the sensor at one keyframe.
struct SpeedFactor {
  int keyframe = 0;
  int rows = 3;                                        ///< components in use: 1, forward; or 3
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the origin of s, in s [m/s]
  /// W^T W is the information of `velocity`; zero in components that are not in use.
  Eigen::Matrix3d W = Eigen::Matrix3d::Zero();
};

/// Interpolated linearly to the keyframes moved by `td_shift` [s]. A keyframe that lies between no
/// two speeds at most InitWindow::kMaxSpeedGap apart has none.
std::vector<SpeedFactor> speedFactors(const InitWindow& window, double td_shift);

/// Columns: theta, v of the keyframe, b_g, rotation of the rig.
constexpr int kSpeedColumns = 12;

/// Estimate minus measurement, whitened; and its derivatives.
struct SpeedResidual {
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, kSpeedColumns> J;
  Eigen::Vector3d by_scale;  ///< by the common relative error of the measurements
};

/// `rate`: angular rate of the body at the keyframe without the bias of `state` [rad/s].
/// `calibration` of the window, whose extrinsic rotation RigError::dR corrects.
SpeedResidual speedResidual(const WindowState& state, const SpeedFactor& factor,
                            const Calibration& calibration, const Eigen::Vector3d& rate);

/// All of them together.
struct SpeedFit {
  SpeedUse use;                 ///< with the most probable common error; `missing` is not set
  double cost = 0.0;            ///< there, the prior of that error included
  std::vector<double> weights;  ///< gemanMcClure() of each residual there
  double scale_weight = 1.0;    ///< the same of the common error
};

/// Minimises over the common relative error, which is zero with `scale_sigma` unless the motion
/// says otherwise: then it is free, and all speeds count as contradicted.
SpeedFit fitSpeeds(const std::vector<SpeedResidual>& residuals, double scale_sigma);

}  // namespace slim_init
