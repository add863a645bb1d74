// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is left of the frames that have gone: a linear prior on those that stay, taken by the Schur
// complement (Qin et al. 2018, section VI-D).
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <vector>

#include "window.h"

namespace slim_init::backend {

enum class BlockKind { kPose, kMotion };

/// One parameter block of one frame.
struct BlockKey {
  FrameId frame = -1;
  BlockKind kind = BlockKind::kPose;

  int size() const { return kind == BlockKind::kPose ? kPoseSize : kMotionSize; }
  bool operator<(const BlockKey& other) const {
    return std::tie(frame, kind) < std::tie(other.frame, other.kind);
  }
};

/// The block as a vector, and for a pose its rotation: a point about which something is linear.
struct BlockPoint {
  Eigen::VectorXd x;  ///< position and three zeros, or the motion block
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< of a pose
};

/// |r0 + J dx|^2 with dx the change of the blocks since their first estimate: differences, and for
/// an attitude Log(R_first^T R).
struct Prior {
  std::vector<BlockKey> blocks;
  std::vector<BlockPoint> first;  ///< of each block: fixed when it enters the prior, never moved
  Eigen::MatrixXd J;
  Eigen::VectorXd r0;
  /// Lowest eigenvalue of the information before the square root over the highest, at unit
  /// diagonal; zero up to rounding where a direction is free, never below.
  double lowest_eigenvalue = 0.0;

  bool empty() const { return blocks.empty(); }
};

/// What a seed fixes, as a prior on that frame at its present state: the four free directions of a
/// visual-inertial window, and the biases loosely. Roll and pitch are left to gravity.
Prior anchorAt(const Frame& frame);

/// The prior as a factor over its blocks, in the order of Prior::blocks.
class PriorCost : public ceres::CostFunction {
 public:
  /// The frames of all blocks are in `frames` and, like the prior, outlive the cost.
  PriorCost(const Prior& prior, const Frames& frames);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Prior& prior_;
  std::vector<const Frame*> block_frames_;
};

/// Parameter block of a key.
double* blockData(const BlockKey& key, const Frames& frames);

/// Collects factors and eliminates what goes. Jacobians are taken at first estimates: of blocks
/// that are in the prior already at those of the prior, of the others at their present values;
/// residuals are those of the present values. So no direction gains information by being linearised
/// at two places (Huang et al. 2009).
class Marginalization {
 public:
  /// Starts from the prior in force (may be empty). The frames, whose theta is zero, outlive this
  /// object.
  Marginalization(const Frames& frames, const Prior& prior);

  /// Adds a factor over frame blocks.
  void add(const ceres::CostFunction& cost, const std::vector<BlockKey>& blocks);

  /// Adds the views of one point, factors over (pose, pose, inverse distance), and eliminates its
  /// inverse distance. `loss` weights each view by its present residual.
  struct PointView {
    const ceres::CostFunction* cost;
    BlockKey host, target;
  };
  void addPoint(const std::vector<PointView>& views, double inverse_distance,
                const ceres::LossFunction& loss);

  /// The prior on all blocks touched but `gone`.
  Prior eliminate(const std::set<BlockKey>& gone) const;

 private:
  struct Linearized {
    Eigen::VectorXd r;  ///< at the first estimates, to first order
    Eigen::VectorXd r_present;
    std::vector<Eigen::MatrixXd> J;  ///< one per block; right perturbation for attitudes
    Eigen::VectorXd J_lambda;        ///< of a view of a point
  };
  Linearized linearize(const ceres::CostFunction& cost, const std::vector<BlockKey>& blocks,
                       const double* lambda) const;
  int columnsOf(const BlockKey& key);

  const Frames& frames_;
  std::map<BlockKey, BlockPoint> first_;  ///< of the blocks in the prior
  std::map<BlockKey, int> columns_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd g_;
};

}  // namespace slim_init::backend
