// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What a seed fixes: the four free directions of a visual-inertial window and the biases, loosely.
#pragma once

#include <ceres/sized_cost_function.h>

#include "window.h"

namespace slim_init::backend {

/// Whitened residual [position, heading, b_g, b_a] of one frame against a state, over its blocks
/// pose and motion. Roll and pitch are left to gravity.
class AnchorCost : public ceres::SizedCostFunction<10, kPoseSize, kMotionSize> {
 public:
  static constexpr double kPosition = 1e-3;  ///< holds the free position of the window [m]
  static constexpr double kYaw = 1e-3;       ///< holds its free heading [rad]

  AnchorCost(const Frame& frame, const NavState& seed) : frame_(frame), seed_(seed) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Frame& frame_;
  NavState seed_;
};

}  // namespace slim_init::backend
