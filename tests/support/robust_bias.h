// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "geometry/robust.h"
#include "rotation/robust_bias.h"

namespace slim_init {

/// Under the calibration of the window.
inline RotationUnknowns atBias(const Eigen::Vector3d& gyro_bias) {
  RotationUnknowns x = RotationUnknowns::Zero();
  x.head<3>() = gyro_bias;
  return x;
}

/// Both parts of the estimator, the second where the first is not clean, without a calibration in
/// between; no vanishing points.
inline RobustBias robustBiasOf(const InitWindow& window,
                               const InertialOptions& inertial = InertialOptions()) {
  RobustBiasEstimator estimator(window, nullptr, inertial,
                                {RigError(), window.calibration().sigmas});
  const RobustBias bias = estimator.quick();
  return bias.clean ? bias : estimator.thorough();
}

inline double relativeError(const Eigen::Vector3d& estimate, const Eigen::Vector3d& truth) {
  return (estimate - truth).norm() / truth.norm();
}

}  // namespace slim_init
