// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/robust_bias.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "imu/imu_quality.h"
#include "rotation/constants.h"
#include "rotation/free_rotations.h"
#include "rotation/multi_gap_bias.h"

namespace slim_init {
namespace {

using namespace rotation_constants;  // NOLINT: the constants of this module

// Prune, then minimise over all gaps.
struct RefinementPass {
  double pruning_factor;  // on threshold_sigmas; the first bias may be off by several residuals
  CutoffSchedule schedule;
};

// How a first bias is refined, and again where it does not look clean.
constexpr RefinementPass kQuick[] = {{1.5, {{4.0}, 1}}, {1.0, {{3.0}, 1}}};
constexpr RefinementPass kThorough[] = {
    {1.5, {{5.0, 3.0}, 2}}, {1.0, {{3.0, 3.0}, 2}}, {1.0, {{3.0, 3.0}, 2}}};

}  // namespace

struct RobustBiasEstimator::State {
  State(const InitWindow& seen, const std::vector<VanishingPoint>* vanishing_points,
        const InertialOptions& priors, WorkBudget* work)
      : window(seen), inertial(priors), budget(work), problem(seen, vanishing_points, priors) {
    for (const KeyframePair& pair : problem.pairs()) points += pair.points.count();
    spend(kWorkPerKeyframe * seen.size());
    found.point_pairs = problem.pointPairs();
  }

  // A bias from pairs up to kShortGap keyframes, from a bias of zero. No track is pruned yet.
  void start();
  template <std::size_t N>
  void refine(const RefinementPass (&passes)[N]);
  // What follows from the bias.
  RobustBias finish();

  void minimize(const Eigen::Vector3d& from, int max_gap, const CutoffSchedule& schedule,
                const PointMasks& masks, Baselines baselines) {
    minimum = problem.minimize(from, max_gap, schedule, masks, std::move(baselines));
    spend(kWorkPerPair * static_cast<double>(problem.pairs().size()) * minimum.iterations);
  }
  void spend(double work) {
    if (budget != nullptr) budget->spend(work);
  }

  const InitWindow& window;
  const InertialOptions& inertial;
  WorkBudget* budget;
  MultiGapProblem problem;
  double points = 0.0;  // of all pairs
  BiasMinimum minimum;  // baselines those of the rating
  RobustBias found;
};

void RobustBiasEstimator::State::start() {
  spend(kWorkPerPoint * points);
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const ConsensusOptions draw = {*kNarrowStart.begin()};
  minimize(
      zero, kShortGap, kNarrowStart, {},
      problem.findBaselines(zero, kShortGap, draw, unknownBaselines(problem.pairs())).baselines);
}

template <std::size_t N>
void RobustBiasEstimator::State::refine(const RefinementPass (&passes)[N]) {
  for (const RefinementPass& pass : passes) {
    spend(kWorkPerPoint * points);
    const Eigen::Vector3d bias = minimum.gyro_bias;
    PairPruning pruning = pruneTracks(window, problem.pairs(), problem.rotationsAt(bias, kLongGap),
                                      {pass.pruning_factor * kAgreementSigmas}, minimum.baselines);
    BaselineConsensus searched =
        problem.findBaselines(bias, kLongestGap, {kAgreementSigmas}, std::move(pruning.baselines));
    found.pruning = std::move(pruning.tracks);
    minimize(bias, kLongestGap, pass.schedule, masksOf(problem.pairs(), found.pruning.keep),
             std::move(searched.baselines));
  }
  BaselineConsensus rated = problem.findBaselines(minimum.gyro_bias, kLongGap, {kOutlierSigmas, 0},
                                                  std::move(minimum.baselines));
  minimum.baselines = std::move(rated.baselines);
  found.cost = rated.cost;
}

RobustBias RobustBiasEstimator::State::finish() {
  RobustBias out = found;
  out.gyro_bias = minimum.gyro_bias;
  if (!out.gyro_bias.allFinite() || out.gyro_bias.norm() > kMaxBias) {
    out.status = RobustBiasStatus::kOutOfRange;
    return out;
  }
  out.imu_noise = assumedImuNoise(window, inertial);
  const Baselines baselines =
      problem.baselinesAt(out.gyro_bias, kLongestGap, minimum.weighted, minimum.baselines);
  out.rotations = freeRotations(problem.pairs(), problem.rotationsAt(out.gyro_bias, kShortGap),
                                baselines, kShortGap, out.clean ? kFreeFromClean : kFreeFromFar);
  out.track_sigma = trackNoise(problem.pairs(), out.rotations);
  out.readout = checkReadout(window, problem.pairs(), out.rotations, out.gyro_bias,
                             std::fmax(out.track_sigma, problem.pairs().sigma()));
  out.status = out.inlierFraction() < kMinInlierFraction ? RobustBiasStatus::kNoConsensus
                                                         : RobustBiasStatus::kOk;
  return out;
}

RobustBiasEstimator::RobustBiasEstimator(const InitWindow& window,
                                         const std::vector<VanishingPoint>* vanishing_points,
                                         const InertialOptions& inertial, WorkBudget* budget)
    : state_(std::make_unique<State>(window, vanishing_points, inertial, budget)) {}

RobustBiasEstimator::~RobustBiasEstimator() = default;

RobustBias RobustBiasEstimator::quick() {
  State& s = *state_;
  if (s.found.point_pairs == 0) return s.found;
  s.start();
  s.refine(kQuick);
  s.found.clean = s.found.inlierFraction() >= kCleanInlierFraction && s.found.cost <= kCleanCost;
  return s.finish();
}

RobustBias RobustBiasEstimator::thorough() {
  State& s = *state_;
  if (s.found.point_pairs == 0) return s.found;
  if (s.budget == nullptr || !s.budget->isUsedUp()) s.refine(kThorough);
  return s.finish();
}

}  // namespace slim_init
