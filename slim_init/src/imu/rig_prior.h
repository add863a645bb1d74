// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is known of the calibration before the data of a window, as a term of a cost.
#pragma once

#include <Eigen/Core>

#include "imu/window_state.h"
#include "slim_init/types.h"

namespace slim_init {

/// Information that holds a bias, or an inverse depth, at zero, 1 / (1e-6 m/s^2)^2.
inline constexpr double kHold = 1e12;

/// What is known about the rig before the data.
struct RigPrior {
  RigError mean;             ///< of the prior, against the calibration of the window
  CalibrationSigmas sigmas;  ///< zero: held at the mean
};

using RigMatrix = Eigen::Matrix<double, StateLayout::kRig, StateLayout::kRig>;
using RigVector = Eigen::Matrix<double, StateLayout::kRig, 1>;

/// Normal equations of the prior at an error of the rig, rows as StateLayout has them: rotation,
/// translation, td, readout time.
struct RigPriorTerm {
  RigMatrix H = RigMatrix::Zero();
  RigVector g = RigVector::Zero();  ///< half the derivative of the cost
  double cost = 0.0;
};

/// A calibration may be wrong by more than its standard deviations say, so each part of the prior
/// has the cost of Geman and McClure (docs/derivation.md, 4.10): extrinsic rotation with td, since
/// who has one of them wrong has not measured the other with care either; the lever arm; the
/// readout time. `rig` is an error against the calibration of the window.
RigPriorTerm rigPriorTerm(const RigPrior& prior, const RigError& rig);

}  // namespace slim_init
