// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rotations that the points of a keyframe pair measure alone, for the check of the calibration
// (docs/derivation.md, 6.1).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "rotation/constants.h"
#include "rotation/keyframe_pairs.h"

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

/// The pairs `gap` keyframes apart with their rotation freed from that of the gyroscope,
/// `rotations` at the bias. A schedule that begins with tens of standard deviations finds rotations
/// that are degrees off. Pairs whose points do not determine a rotation are left out. All points
/// take part, whatever the pruning says.
std::vector<RotationCorrection> freeRotations(const KeyframePairs& pairs,
                                              const PairRotations& rotations,
                                              const Baselines& baselines, int gap,
                                              const CutoffSchedule& schedule);

}  // namespace slim_init
