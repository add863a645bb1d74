// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is known of calibration and biases before the data of a window, as terms of a cost.
#pragma once

#include <Eigen/Core>

#include "imu/window_state.h"
#include "slim_init/options.h"
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

/// What is known of the biases before the data: `known` where its standard deviations are below
/// those of `options`, which hold otherwise, about zero.
ImuBiases assumedImuBiases(const ImuBiases& known, const InertialOptions& options);
/// Whether one of them is known so.
bool areKnown(const ImuBiases& biases, const InertialOptions& options);

/// The prior of the accelerometer bias at a bias.
struct AccelBiasTerm {
  double cost;
  double sigma;  ///< of the Gaussian about the same mean that has its gradient [m/s^2]
};
/// If it is not known, the bias may be larger than `options` say: Student's t of two degrees of
/// freedom, near its mean the Gaussian. With more degrees it holds back a bias of 0.8 m/s^2; with a
/// cost that ends (gemanMcClureCost()) the model errors of a vibrating IMU draw the bias away.
AccelBiasTerm accelBiasTerm(const ImuBiases& known, const InertialOptions& options,
                            const Eigen::Vector3d& accel_bias);

}  // namespace slim_init
