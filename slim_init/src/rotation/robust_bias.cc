// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/robust_bias.h"

#include <cmath>
#include <utility>

#include "geometry/robust.h"

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
                                         const InertialOptions& inertial, WorkBudget* budget)
    : window_(window), budget_(budget), problem_(window, vanishing_points, inertial) {
  for (const KeyframePair& pair : problem_.pairs()) points_ += pair.points.count();
  spend(kWorkPerKeyframe * window.size());
}

void RobustBiasEstimator::spend(double work) {
  if (budget_ != nullptr) budget_->spend(work);
}

double RobustBiasEstimator::findBaselines(int max_gap, const ConsensusOptions& options) {
  return slim_init::findBaselines(problem_.pairs(),
                                  problem_.rotationsAt(minimum_.gyro_bias, max_gap), max_gap,
                                  options, &minimum_.baselines);
}

void RobustBiasEstimator::minimize(int max_gap, const CutoffSchedule& schedule,
                                   const PointMasks& masks) {
  minimum_ = problem_.minimize(minimum_.gyro_bias, max_gap, schedule, masks,
                               std::move(minimum_.baselines));
  spend(kWorkPerPair * static_cast<double>(problem_.pairs().size()) * minimum_.iterations);
}

void RobustBiasEstimator::start() {
  spend(kWorkPerPoint * points_);
  minimum_.baselines = unknownBaselines(problem_.pairs());
  findBaselines(kShortGap, {kNarrowStart.front()});
  minimize(kShortGap, kNarrowStart, {});
}

void RobustBiasEstimator::refine(const std::vector<RefinementPass>& passes) {
  for (const RefinementPass& pass : passes) {
    spend(kWorkPerPoint * points_);
    found_.pruning =
        pruneTracks(window_, problem_.pairs(), problem_.rotationsAt(minimum_.gyro_bias, kLongGap),
                    {pass.pruning_factor * kAgreementSigmas}, &minimum_.baselines);
    findBaselines(kLongestGap, {kAgreementSigmas});
    minimize(kLongestGap, pass.schedule, masksOf(problem_.pairs(), found_.pruning.keep));
  }
  found_.cost = findBaselines(kLongGap, {kOutlierSigmas, 0});
}

RobustBias RobustBiasEstimator::finish() {
  RobustBias out = found_;
  out.gyro_bias = minimum_.gyro_bias;
  if (!out.gyro_bias.allFinite() || out.gyro_bias.norm() > kMaxBias) {
    out.status = InitStatus::kNumericalFailure;
    return out;
  }
  const KeyframePairs& pairs = problem_.pairs();
  const Baselines baselines = problem_.baselinesAt(minimum_, kLongestGap);
  out.rotations = freeRotations(pairs, problem_.rotationsAt(out.gyro_bias, kShortGap), baselines,
                                kShortGap, out.clean ? kFreeFromClean : kFreeFromFar);
  out.track_sigma = trackNoise(pairs, out.rotations);
  out.readout = checkReadout(window_, pairs, out.rotations, out.gyro_bias,
                             std::fmax(out.track_sigma, pairs.sigma()));
  out.status = out.inlierFraction() < kMinInlierFraction ? InitStatus::kInconsistentResiduals
                                                         : InitStatus::kSuccess;
  return out;
}

RobustBias RobustBiasEstimator::quick() {
  if (problem_.pairs().pointPairs() == 0) return found_;
  start();
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
