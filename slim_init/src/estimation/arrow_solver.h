// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The Gauss-Newton step of the refinement from its normal equations.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "imu/window_state.h"

namespace slim_init {

/// Solves normal equations in the layout of StateLayout. Without row times of their own the
/// velocities appear in the IMU factors alone: one couples with its two neighbours, with the poses
/// of the same keyframes, and with biases, gravity and rig. They are eliminated first, in time,
/// with the poses in reverse behind them: what couples with a velocity is then one range of rows,
/// and fill stays in it. Memory is kept from one call to the next.
class ArrowSolver {
 public:
  /// `dense_velocities`: velocities couple with everything (rolling shutter).
  ArrowSolver(const StateLayout& layout, bool dense_velocities);

  /// Step -(H + damping diag H)^-1 g without the gauge, whose part of `step` (layout.size()) is
  /// zero. H: layout.size() square, lower triangle read. False where the damped matrix is not
  /// positive definite; step is then undefined.
  bool solve(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, double damping,
             Eigen::VectorXd* step);

 private:
  // Of one velocity: its block (then its factor), the block of the next one with it, and the
  // rows of the rest with it.
  struct Velocity {
    Eigen::Matrix3d block, next;
    int first_row = 0;  // of the rest
  };

  void copyVelocities(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, double damping);
  void copyRest(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, double damping);
  bool eliminateVelocities();

  StateLayout layout_;
  bool dense_velocities_;
  std::vector<int> rest_;  // index in the layout of every unknown of the rest
  Eigen::MatrixXd A_;      // of the rest, the gradient as its last row
  std::vector<Velocity> velocities_;
  Eigen::MatrixXd panels_;  // rows of the rest with the velocities, three columns each
};

}  // namespace slim_init
