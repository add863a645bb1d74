// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// IMU factor between two frames: preintegrated motion and bias random walk (Forster et al. 2017).
#pragma once

#include <ceres/sized_cost_function.h>

#include "imu/preintegration.h"
#include "window.h"

namespace slim_init::backend {

/// Whitened residual [rotation, velocity, position, b_g walk, b_a walk] over the blocks pose and
/// motion of frame i, pose and motion of frame j. Biases of frame i enter the preintegration to
/// first order.
class InertialCost
    : public ceres::SizedCostFunction<15, kPoseSize, kMotionSize, kPoseSize, kMotionSize> {
 public:
  /// `pre` with covariance; frames outlive the cost. `gravity_w` [m/s^2], walks as in
  /// EstimatorOptions. Null where the covariance is not positive definite.
  static std::unique_ptr<InertialCost> create(const Frame& i, const Frame& j,
                                              const Preintegration& pre,
                                              const Eigen::Vector3d& gravity_w,
                                              double gyro_bias_walk, double accel_bias_walk);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  InertialCost(const Frame& i, const Frame& j, const Preintegration& pre,
               const Eigen::Vector3d& gravity_w);

  const Frame& i_;
  const Frame& j_;
  Preintegration pre_;
  Eigen::Vector3d gravity_w_;
  Eigen::Matrix<double, 9, 9> whitening_;
  double gyro_walk_weight_ = 0.0;
  double accel_walk_weight_ = 0.0;
};

}  // namespace slim_init::backend
