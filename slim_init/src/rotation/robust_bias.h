// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// First stage of `slim`: gyroscope bias, extrinsic rotation and td by consensus, tracks pruned with
// them, and all three again from what is left (docs/derivation.md, 1.3).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lines/vanishing_point.h"
#include "rotation/camera_check.h"
#include "rotation/multi_gap_bias.h"
#include "rotation/track_pruning.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/work_budget.h"

namespace slim_init {

/// A larger bias is a numerical failure [rad/s].
inline constexpr double kMaxBias = 1.0;
/// With a smaller share of agreeing observations there is no consensus.
inline constexpr double kMinInlierFraction = 0.3;
/// Start from a bias of zero at short gaps where the calibration is right; kWideStart where it may
/// be degrees off.
inline const CutoffSchedule kNarrowStart = {3.0, 3.0};

/// Gyroscope bias with the observations that agree with it.
struct RobustBias {
  /// kTooFewTracks: no keyframe pair has kMinPointsPerPair common points; kInconsistentResiduals:
  /// fewer than kMinInlierFraction of the observations agree with any bias; kNumericalFailure: the
  /// bias is not finite or larger than kMaxBias.
  InitStatus status = InitStatus::kTooFewTracks;
  bool valid() const { return status == InitStatus::kSuccess; }
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();  ///< [rad/s]
  /// Rotation and td of the calibration against that of the window.
  RigError rig;
  TrackPruning pruning;  ///< keep mask for withObservations() and counts, at `gyro_bias`
  /// Mean squared residual over keyframe pairs at gaps 1, 2 and 4 before any pruning, truncated at
  /// 9 [sigma^2]; up to 1 when the pixel noise is the calibration's and nothing is wrong.
  double cost = 0.0;
  /// Of the pairs two keyframes apart, each with the rotation that the points alone see [rad].
  double track_sigma = kNotComputed;
  ReadoutCheck readout;  ///< of the same pairs
  bool clean = false;    ///< the quick estimate was good enough

  /// Share of the checked observations that agree with the bias.
  double inlierFraction() const { return pruning.inlierFraction(); }
};

/// Prune, then minimise over all gaps.
struct RefinementPass {
  double pruning_factor;  ///< on kAgreementSigmas; the first bias may be off by several residuals
  CutoffSchedule schedule;
};

/// Estimates the bias of a window of two or more keyframes, in two parts for a caller that can see
/// in the first answer why it is not clean. `vanishing_points` may be null, else one per keyframe.
/// `rig`: what is known of extrinsic rotation and td. Deterministic. `budget` (null: none) counts
/// the work; used up, no further start is tried: a wrong bias shows in the fit of everything after
/// it. What is handed in has to outlive the search.
class RobustBiasEstimator {
 public:
  RobustBiasEstimator(const InitWindow& window, const std::vector<VanishingPoint>* vanishing_points,
                      const InertialOptions& inertial, const RigPrior& rig,
                      WorkBudget* budget = nullptr);

  /// Few passes. To be called once, before thorough().
  RobustBias quick();
  /// Where quick() was not clean: more passes.
  RobustBias thorough();

 private:
  // From pairs up to kShortGap keyframes and unknowns of zero. No track is pruned yet. Returns the
  // mean truncated squared residual.
  double start(const CutoffSchedule& schedule);
  void refine(const std::vector<RefinementPass>& passes);
  // What follows from the minimum.
  RobustBias finish();
  // Both from `minimum_` on.
  double findBaselines(int max_gap, const ConsensusOptions& options);
  void minimize(int max_gap, const CutoffSchedule& schedule, const PointMasks& masks);
  void spend(double work);

  const InitWindow& window_;
  WorkBudget* budget_;
  MultiGapProblem problem_;
  double points_ = 0.0;      // of all pairs
  RotationMinimum minimum_;  // baselines those of the rating
  RobustBias found_;
};

}  // namespace slim_init
