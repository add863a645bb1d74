// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Gyroscope bias of `slim`: noise-normalised epipolar cost over keyframe pairs at several gaps,
// with vanishing points weighted by their own covariance.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "imu/preintegration.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "structure/vanishing_point.h"

namespace slim_init {

/// Result of the estimation.
struct MultiGapBiasEstimate {
  bool valid = false;  ///< some pair had data, the bias is finite and at most max_bias
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();  ///< [rad/s]
  double cost = 0.0;  ///< robust cost, comparable between starts on the same data
  /// Gauss-Newton information of the bias [1/(rad/s)^2].
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  int iterations = 0;
  int point_pairs = 0;
  int vp_pairs = 0;
};

/// VP residual in the tangent plane of d_j, whitened by the covariances of both directions.
/// `residual` 2, `jacobian` 2x3 under R_bi_bj Exp(phi). The sign of d_i is chosen freely.
void whitenedVpResidual(const VanishingPoint& vp_i, const VanishingPoint& vp_j,
                        const Eigen::Matrix3d& R_bi_bj, const Eigen::Matrix3d& R_b_c,
                        double inflation, Eigen::Vector2d* residual,
                        Eigen::Matrix<double, 2, 3>* jacobian);

/// Minimises from each of `starts` and keeps the lowest cost. `vanishing_points` may be null, else
/// one per keyframe.
MultiGapBiasEstimate estimateMultiGapBias(const InitWindow& window,
                                          const std::vector<Eigen::Vector3d>& starts,
                                          const std::vector<VanishingPoint>* vanishing_points,
                                          const MultiGapBiasOptions& options);

}  // namespace slim_init
