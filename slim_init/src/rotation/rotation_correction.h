// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace slim_init {

/// Rotation of a keyframe pair as its points alone have it, against the gyroscope's.
struct RotationCorrection {
  std::size_t pair = 0;  ///< index into the KeyframePairs
  int i = 0, j = 0;
  Eigen::Matrix3d R_ci_cj = Eigen::Matrix3d::Identity();  ///< from the gyroscope, bias taken off
  Eigen::Matrix3d dR_dbg = Eigen::Matrix3d::Zero();       ///< R Exp(dR_dbg d) for a bias d more
  Eigen::Vector3d phi = Eigen::Vector3d::Zero();          ///< the points have R Exp(phi) [rad]
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of phi [1/rad^2]
  Eigen::Vector3d baseline = Eigen::Vector3d::Zero();     ///< unit, in c_i, at R Exp(phi)
};

}  // namespace slim_init
