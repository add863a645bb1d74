// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rotation between two images from common points alone: no gyro, no extrinsic.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slim_init {

/// Unit bearings of a point in cameras i and j.
struct BearingPair {
  Eigen::Vector3d f_i, f_j;
};

struct RelativeRotation {
  Eigen::Matrix3d R_ci_cj = Eigen::Matrix3d::Identity();
  /// Of delta in R_ci_cj Exp(delta) [1/rad^2]; the direction of travel is eliminated.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double residual = 0.0;  ///< robust standard deviation of a bearing across its epipolar plane
  double flow = 0.0;      ///< median angle between the bearings [rad]
};

/// Minimises sum rho((e . m)^2 / n), m = f_i x R f_j, n = |e x f_i|^2 + |R^T e x f_j|^2 (the
/// variance of e . m for bearings of unit noise), over the rotation R and the direction e of
/// travel. `sigma` [rad] is the noise of a bearing, for the search. `start`: of the search; null:
/// from the best rotation without travel and from rotations near it. Points at rest or far away are
/// fine: the direction is then of no meaning, the rotation is. One point in ten may be an outlier.
/// False with fewer than eight points
/// or when nothing fits.
bool relativeRotation(const std::vector<BearingPair>& points, double sigma,
                      const Eigen::Matrix3d* start, RelativeRotation* result);

}  // namespace slim_init
