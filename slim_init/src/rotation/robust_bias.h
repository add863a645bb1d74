// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// First stage of `slim`: a gyroscope bias by consensus, tracks pruned with it, and the bias again
// from what is left (docs/derivation.md, 1.3).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lines/vanishing_point.h"
#include "rotation/calibration_check.h"
#include "rotation/free_rotations.h"
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
/// Start from a bias of zero at short gaps.
inline const CutoffSchedule kNarrowStart = {3.0, 3.0};

/// Gyroscope bias with the observations that agree with it.
struct RobustBias {
  /// kTooFewTracks: no keyframe pair has kMinPointsPerPair common points; kInconsistentResiduals:
  /// fewer than kMinInlierFraction of the observations agree with any bias; kNumericalFailure: the
  /// bias is not finite or larger than kMaxBias.
  InitStatus status = InitStatus::kTooFewTracks;
  bool valid() const { return status == InitStatus::kSuccess; }
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();  ///< [rad/s]
  TrackPruning pruning;  ///< keep mask for withObservations() and counts, at `gyro_bias`
  /// Mean squared residual over keyframe pairs at gaps 1, 2 and 4 before any pruning, truncated at
  /// 9 [sigma^2]; up to 1 when the pixel noise is the calibration's and nothing is wrong.
  double cost = 0.0;
  /// Pairs two keyframes apart with the rotation that the points alone see, for the check of the
  /// calibration. Rotations that are degrees off are found where the bias did not look clean.
  std::vector<RotationCorrection> rotations;
  double track_sigma = kNotComputed;  ///< trackNoise() of these pairs [rad]
  ReadoutCheck readout;               ///< checkReadout() of these pairs
  bool clean = false;                 ///< the quick estimate was good enough

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
/// Deterministic. `budget` (null: none) counts the work; used up, no further start is tried: a
/// wrong bias shows in the fit of everything after it. What is handed in has to outlive the search.
class RobustBiasEstimator {
 public:
  RobustBiasEstimator(const InitWindow& window, const std::vector<VanishingPoint>* vanishing_points,
                      const InertialOptions& inertial, WorkBudget* budget = nullptr);

  /// Few passes. To be called once, before thorough().
  RobustBias quick();
  /// Where quick() was not clean: more passes.
  RobustBias thorough();

 private:
  // A bias from pairs up to kShortGap keyframes, from a bias of zero. No track is pruned yet.
  void start();
  void refine(const std::vector<RefinementPass>& passes);
  // What follows from the bias.
  RobustBias finish();
  // Both from the bias and the baselines of `minimum_`.
  double findBaselines(int max_gap, const ConsensusOptions& options);
  void minimize(int max_gap, const CutoffSchedule& schedule, const PointMasks& masks);
  void spend(double work);

  const InitWindow& window_;
  WorkBudget* budget_;
  MultiGapProblem problem_;
  double points_ = 0.0;  // of all pairs
  BiasMinimum minimum_;  // baselines those of the rating
  RobustBias found_;
};

}  // namespace slim_init
