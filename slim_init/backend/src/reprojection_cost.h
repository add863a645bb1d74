// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// One view of a point, which is held by the bearing and inverse distance of its first view (Qin et
// al. 2018, section VI-C).
#pragma once

#include <ceres/sized_cost_function.h>

#include "slim_init/types.h"
#include "window.h"

namespace slim_init::backend {

/// Direction in the second camera of a point at inverse distance `lambda` along `bearing_i`, times
/// lambda: finite also for a point at infinity. In c_j.
struct TransferredPoint {
  Eigen::Vector3d q;       ///< lambda times the point in c_j
  Eigen::Vector3d in_b_i;  ///< lambda times the point in b_i
  Eigen::Vector3d in_b_j;  ///< lambda times the point in b_j
};
TransferredPoint transferPoint(const Eigen::Matrix3d& R_i, const Eigen::Vector3d& p_i,
                               const Eigen::Matrix3d& R_j, const Eigen::Vector3d& p_j,
                               const Calibration& calibration, const Eigen::Vector3d& bearing_i,
                               double lambda);

/// Whitened residual in the tangent plane of the observed bearing, over the blocks pose of the
/// first view's frame i, pose of frame j, inverse distance [1/m]. Evaluation fails where the point
/// falls into the centre of camera j.
class ReprojectionCost : public ceres::SizedCostFunction<2, kPoseSize, kPoseSize, 1> {
 public:
  /// Bearings are unit vectors in c. Frames and calibration outlive the cost. `sigma` [rad].
  ReprojectionCost(const Frame& i, const Frame& j, const Calibration& calibration,
                   const Eigen::Vector3d& bearing_i, const Eigen::Vector3d& bearing_j,
                   double sigma);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Frame& i_;
  const Frame& j_;
  const Calibration& calibration_;
  Eigen::Vector3d bearing_i_;
  Eigen::Matrix<double, 2, 3> weighted_tangent_;  ///< rows of the tangent basis over sigma
};

}  // namespace slim_init::backend
