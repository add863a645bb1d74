// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rotations that the points of a pair of images measure alone: for the check of the calibration
// (docs/derivation.md, 6.1), and from nothing (6.2).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "rotation/keyframe_pairs.h"

namespace slim_init {

/// Freed rotations where the bias looks clean, and where the calibration may be degrees off: 40 are
/// 24 px, what eight degrees of extrinsic rotation make of a quick turn.
inline const CutoffSchedule kFreeFromClean = {3.0};
inline const CutoffSchedule kFreeFromFar = {40.0, 10.0, 3.0, 3.0};

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

/// Rotation between two images: no gyro, no extrinsic.
struct RelativeRotation {
  Eigen::Matrix3d R_ci_cj = Eigen::Matrix3d::Identity();
  /// Of delta in R_ci_cj Exp(delta) [1/rad^2]; the direction of travel is eliminated.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d baseline = Eigen::Vector3d::Zero();  ///< direction of travel in c_i; zero: none
  double residual = 0.0;  ///< robust standard deviation of a bearing across its epipolar plane
  double flow = 0.0;      ///< median angle between the bearings [rad]
};

/// Minimises the quotient of the points over the rotation. `sigma` [rad] is the noise of a bearing,
/// for the search, which begins from the best rotation without travel and from rotations near it.
/// Points at rest or far away are fine: the direction is then of no meaning, the rotation is. One
/// point in ten may be an outlier. False with fewer than eight points or when nothing fits.
bool relativeRotation(const PairPoints& points, double sigma, RelativeRotation* result);

}  // namespace slim_init
