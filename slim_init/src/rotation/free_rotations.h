// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rotations that the points of a pair of images measure alone: for the check of the camera
// (docs/derivation.md, 6.1), and from nothing (6.2).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "rotation/keyframe_pairs.h"

namespace slim_init {

/// Rotation between two images: no gyro, no extrinsic.
struct RelativeRotation {
  Eigen::Matrix3d R_ci_cj = Eigen::Matrix3d::Identity();
  /// Of delta in R_ci_cj Exp(delta) [1/rad^2]; the direction of travel is eliminated.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d baseline = Eigen::Vector3d::Zero();  ///< direction of travel in c_i; zero: none
  double residual = 0.0;  ///< robust standard deviation of a bearing across its epipolar plane
  double flow = 0.0;      ///< median angle between the bearings [rad]
  std::size_t pair = 0;   ///< index into the KeyframePairs
};

/// The pairs `gap` keyframes apart with their rotation freed from that of the gyroscope,
/// `rotations`, which is near. Those whose points do not determine a rotation are left out. All
/// points take part, whatever the pruning says.
std::vector<RelativeRotation> freeRotations(const KeyframePairs& pairs,
                                            const PairRotations& rotations,
                                            const Baselines& baselines, int gap);

/// Minimises the quotient of the points over the rotation. `sigma` [rad] is the noise of a bearing,
/// for the search, which begins from the best rotation without travel and from rotations near it.
/// Points at rest or far away are fine: the direction is then of no meaning, the rotation is. One
/// point in ten may be an outlier. False with fewer than eight points or when nothing fits.
bool relativeRotation(const PairPoints& points, double sigma, RelativeRotation* result);

/// Variance of Gaussian errors by their squares, not empty, gross errors left out: that of those
/// within kOutlierSigmas.
double noiseVariance(const std::vector<double>& squares);

}  // namespace slim_init
