// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What a seed fixes: the four free directions of a visual-inertial window and the biases, loosely.
#pragma once

#include <ceres/sized_cost_function.h>

#include "slim_init/backend/options.h"
#include "window.h"

namespace slim_init::backend {

/// Whitened residual [position, heading, b_g, b_a] of one frame against a state, over its blocks
/// pose and motion. Roll and pitch are left to gravity.
class AnchorCost : public ceres::SizedCostFunction<10, kPoseSize, kMotionSize> {
 public:
  AnchorCost(const Frame& frame, const NavState& seed, const EstimatorOptions& options);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Frame& frame_;
  NavState seed_;
  double position_weight_, yaw_weight_, gyro_bias_weight_, accel_bias_weight_;
};

}  // namespace slim_init::backend
