// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/robust_bias.h"

#include <cmath>
#include <utility>

#include "geometry/robust.h"
#include "geometry/so3.h"
#include "rotation/free_rotations.h"

namespace slim_init {
namespace {

// A solution is clean and kept from this fraction of agreeing observations on, and below this mean
// truncated squared residual [sigma^2]. Right solutions of clean windows have 0.9, one in ten 1.1;
// wrong minima mostly 1.2 to 2.4.
constexpr double kCleanInlierFraction = 0.97;
constexpr double kCleanCost = 1.15;
// Work of one bias per keyframe; of one pass per common point of a pair; and of one iteration per
// pair [units].
constexpr double kWorkPerKeyframe = 30.0;
constexpr double kWorkPerPoint = 0.15;
constexpr double kWorkPerPair = 0.35;

// How a first bias is refined, and again where it does not look clean.
const std::vector<RefinementPass> kQuick = {{1.5, {4.0}}, {1.0, {3.0}}};
const std::vector<RefinementPass> kThorough = {
    {1.5, {5.0, 3.0}}, {1.0, {3.0, 3.0}}, {1.0, {3.0, 3.0}}};

}  // namespace

RobustBiasEstimator::RobustBiasEstimator(const InitWindow& window,
                                         const std::vector<VanishingPoint>* vanishing_points,
                                         const InertialOptions& inertial, const RigPrior& rig,
                                         WorkBudget* budget)
    : window_(window), budget_(budget), problem_(window, vanishing_points, inertial, rig) {
  for (const KeyframePair& pair : problem_.pairs()) points_ += pair.points.count();
  spend(kWorkPerKeyframe * window.size());
}

void RobustBiasEstimator::spend(double work) {
  if (budget_ != nullptr) budget_->spend(work);
}

double RobustBiasEstimator::findBaselines(int max_gap, const ConsensusOptions& options) {
  return slim_init::findBaselines(problem_.pairs(), problem_.rotationsAt(minimum_.x, max_gap),
                                  max_gap, options, &minimum_.baselines);
}

void RobustBiasEstimator::minimize(int max_gap, const CutoffSchedule& schedule,
                                   const PointMasks& masks) {
  minimum_ = problem_.minimize(minimum_.x, max_gap, schedule, masks, std::move(minimum_.baselines));
  spend(kWorkPerPair * static_cast<double>(problem_.pairs().size()) * minimum_.iterations);
}

double RobustBiasEstimator::start(const CutoffSchedule& schedule) {
  spend(kWorkPerPoint * points_);
  minimum_ = RotationMinimum();
  minimum_.x = problem_.priorMean();
  minimum_.baselines.assign(problem_.pairs().size(), Eigen::Vector3d::Zero());
  findBaselines(kShortGap, {schedule.front()});
  minimize(kShortGap, schedule, {});
  return findBaselines(kShortGap, {kOutlierSigmas});
}

void RobustBiasEstimator::refine(const std::vector<RefinementPass>& passes) {
  for (const RefinementPass& pass : passes) {
    spend(kWorkPerPoint * points_);
    const double threshold = pass.pruning_factor * kAgreementSigmas;
    findBaselines(kLongestGap, {threshold});
    found_.pruning =
        pruneTracks(window_, problem_.pairs(), problem_.rotationsAt(minimum_.x, kLongGap),
                    threshold, &minimum_.baselines);
    minimize(kLongestGap, pass.schedule, masksOf(problem_.pairs(), found_.pruning.keep));
  }
  found_.cost = findBaselines(kLongGap, {kOutlierSigmas, 0});
}

RobustBias RobustBiasEstimator::finish() {
  RobustBias out = found_;
  const RotationUnknowns& x = minimum_.x;
  out.gyro_bias = x.head<3>();
  if (!x.allFinite() || out.gyro_bias.norm() > kMaxBias) {
    out.status = InitStatus::kNumericalFailure;
    return out;
  }
  out.rig.dR = expSO3(x.segment<3>(3));
  out.rig.dtd = x[6];
  const KeyframePairs& pairs = problem_.pairs();
  const std::vector<RelativeRotation> rotations =
      freeRotations(pairs, problem_.rotationsAt(x, kShortGap),
                    problem_.baselinesAt(minimum_, kLongestGap), kShortGap);
  out.track_sigma = trackNoise(pairs, rotations);
  out.readout = checkReadout(window_, pairs, rotations, out.gyro_bias,
                             std::fmax(out.track_sigma, pairs.sigma()));
  out.status = out.inlierFraction() < kMinInlierFraction ? InitStatus::kInconsistentResiduals
                                                         : InitStatus::kSuccess;
  return out;
}

RobustBias RobustBiasEstimator::quick() {
  if (problem_.pairs().pointPairs() == 0) return found_;
  const double narrow = start(kNarrowStart);
  if (narrow > kCleanCost && (budget_ == nullptr || !budget_->isUsedUp())) {
    RotationMinimum near = minimum_;
    // It has to halve what the other one leaves above noise: it is free to explain errors.
    if (!(2.0 * (start(kWideStart) - 1.0) < narrow - 1.0)) minimum_ = std::move(near);
  }
  refine(kQuick);
  found_.clean = found_.inlierFraction() >= kCleanInlierFraction && found_.cost <= kCleanCost;
  return finish();
}

RobustBias RobustBiasEstimator::thorough() {
  if (problem_.pairs().pointPairs() == 0) return found_;
  if (budget_ == nullptr || !budget_->isUsedUp()) refine(kThorough);
  return finish();
}

}  // namespace slim_init
