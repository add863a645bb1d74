// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Structureless visual-inertial bundle adjustment (Song, Richard, Olivares-Mendez, "Improving
// Monocular Visual-Inertial Initialization with Structureless Visual-Inertial Bundle Adjustment",
// 2025): no point is a state, vision enters by the coplanarity of two rays and their baseline.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "slim_init/baselines/options.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"

namespace slim_init::baselines {

/// What the minimisation reports.
struct EpipolarAdjustment {
  bool valid = false;      ///< every IMU covariance is positive definite and the cost is finite
  bool converged = false;  ///< the relative decrease of the cost fell below the tolerance
  int iterations = 0;      ///< accepted steps
  int residuals = 0;       ///< epipolar residuals
  double first_cost = 0.0;
  double cost = 0.0;
  /// Information of the error vector without the gauge (StateLayout, from index kGauge on).
  Eigen::MatrixXd information;
};

/// Minimises from `state`, over keyframe states, both biases and the direction of gravity,
///   sum over consecutive keyframes |IMU residual|^2
///   + sum over tracks and every pair of their keyframes rho(r^2 / sigma^2) + |b_a|^2 / sigma_ba^2,
/// rho Huber's, sigma_ba 0.1 m/s^2, by Levenberg-Marquardt. `pre`: one per consecutive pair, with
/// covariance, at the biases of `state`. The paper has biases at every keyframe, tied by a random
/// walk; over a window of seconds that walk is a hundredth of the biases, and here they are one.
EpipolarAdjustment adjustEpipolar(const InitWindow& window, const std::vector<Preintegration>& pre,
                                  const DrtViBaOptions& options, WindowState* state);

}  // namespace slim_init::baselines
