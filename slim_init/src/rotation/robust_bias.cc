// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/robust_bias.h"

#include <cmath>
#include <utility>

#include "imu/imu_quality.h"
#include "rotation/constants.h"
#include "rotation/free_rotations.h"
#include "rotation/multi_gap_bias.h"

namespace slim_init {
namespace {

using namespace rotation_constants;  // NOLINT: the constants of this module

// Whether the baselines of the pruning serve the minimisation that follows.
enum class Baselining { kFromPruning, kSearchAllGaps };

// Prune, then minimise over all gaps.
struct RefinementPass {
  double pruning_factor;  // on threshold_sigmas; the first bias may be off by several residuals
  Baselining baselining;
  CutoffSchedule schedule;
};

// How a first bias is refined.
struct RefinementSchedule {
  RefinementPass passes[3];
  int count;
  ConsecutivePairs consecutive_pairs;
  BaselineSearch search;  // of pruning and minimisation
  // Whether directions are drawn to rate the answer, or those of the last pass rated.
  bool draw_for_score;

  const RefinementPass* begin() const { return passes; }
  const RefinementPass* end() const { return passes + count; }
};
constexpr RefinementSchedule kQuick = {
    {{1.5, Baselining::kSearchAllGaps, {{4.0}, 1}}, {1.0, Baselining::kFromPruning, {{3.0}, 1}}},
    2,
    ConsecutivePairs::kWhereNeeded,
    BaselineSearch::kUnlessGood,
    false};
constexpr RefinementSchedule kThorough = {{{1.5, Baselining::kSearchAllGaps, {{5.0, 3.0}, 2}},
                                           {1.0, Baselining::kSearchAllGaps, {{3.0, 3.0}, 2}},
                                           {1.0, Baselining::kSearchAllGaps, {{3.0, 3.0}, 2}}},
                                          3,
                                          ConsecutivePairs::kUse,
                                          BaselineSearch::kAlways,
                                          true};

// A bias with the tracks that agree with it.
struct Candidate {
  TrackPruning pruning;  // of the last pass
  BiasMinimum minimum;   // baselines those of the score
  double score = 0.0;    // mean truncated squared residual over all points [sigma^2]
};

class ConsensusSearch {
 public:
  ConsensusSearch(const InitWindow& window, const std::vector<VanishingPoint>* vanishing_points,
                  const RobustBiasOptions& options, const InertialOptions& inertial,
                  WorkBudget* budget)
      : options_(options),
        problem_(window, vanishing_points, options.refinement, inertial),
        budget_(budget) {
    for (const KeyframePair& pair : problem_.pairs()) points_ += pair.points.count();
    if (budget_ != nullptr) budget_->spend(kWorkPerKeyframe * window.size());
  }

  MultiGapProblem& problem() { return problem_; }
  int iterations() const { return iterations_; }
  bool mayGoOn() const { return budget_ == nullptr || !budget_->isUsedUp(); }

  // A bias from pairs up to kShortGap keyframes, from a bias of zero. No track is pruned yet.
  BiasMinimum start() {
    spend(BaselineSearch::kUnlessGood);
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    const ConsensusOptions draw = {*kNarrowStart.begin(), hypotheses(), BaselineSearch::kAlways};
    return minimize(
        zero, problem_.gaps(ConsecutivePairs::kWhereNeeded, kShortGap), kNarrowStart, {},
        problem_.findBaselines(zero, kShortGap, draw, unknownBaselines(problem_.pairs()))
            .baselines);
  }

  Candidate refine(const BiasMinimum& start, const RefinementSchedule& schedule) {
    const GapRange gaps = gapsOf(schedule);
    Candidate out;
    out.minimum = start;
    for (const RefinementPass& pass : schedule) {
      const double threshold = options_.pruning.threshold_sigmas;
      const Eigen::Vector3d bias = out.minimum.gyro_bias;
      PairPruning pruning = pruneTracks(
          problem_.window(), problem_.pairs(), problem_.rotationsAt(bias, kLongGap),
          {pass.pruning_factor * threshold, hypotheses(), schedule.search}, out.minimum.baselines);
      if (pass.baselining == Baselining::kSearchAllGaps) {
        pruning.baselines =
            problem_
                .findBaselines(bias, gaps.to, {threshold, hypotheses(), schedule.search},
                               std::move(pruning.baselines))
                .baselines;
      }
      spend(schedule.search);
      out.pruning = std::move(pruning.tracks);
      out.minimum =
          minimize(bias, gaps, pass.schedule, masks(out.pruning), std::move(pruning.baselines));
    }
    const ConsensusOptions rate = {kOutlierSigmas, schedule.draw_for_score ? hypotheses() : 0,
                                   BaselineSearch::kAlways};
    BaselineConsensus rated = problem_.findBaselines(out.minimum.gyro_bias, kLongGap, rate,
                                                     std::move(out.minimum.baselines));
    out.minimum.baselines = std::move(rated.baselines);
    out.score = rated.cost;
    return out;
  }

  GapRange gapsOf(const RefinementSchedule& schedule) const {
    return problem_.gaps(schedule.consecutive_pairs, options_.refinement.max_gap);
  }

 private:
  int hypotheses() const { return options_.pruning.hypotheses; }
  PointMasks masks(const TrackPruning& pruning) const {
    return masksOf(problem_.window(), problem_.pairs(), pruning.keep);
  }
  BiasMinimum minimize(const Eigen::Vector3d& start, const GapRange& gaps,
                       const CutoffSchedule& schedule, const PointMasks& masks,
                       Baselines baselines) {
    BiasMinimum out = problem_.minimize(start, gaps, schedule, masks, std::move(baselines));
    iterations_ += out.iterations;
    if (budget_ != nullptr) {
      budget_->spend(kWorkPerPair * static_cast<double>(problem_.pairs().size()) * out.iterations);
    }
    return out;
  }
  // Pruning, baselines and weights of one pass.
  void spend(BaselineSearch search) {
    if (budget_ == nullptr) return;
    budget_->spend((search == BaselineSearch::kAlways ? kWorkPerPointDrawn : kWorkPerPoint) *
                   points_);
  }

  const RobustBiasOptions& options_;
  MultiGapProblem problem_;
  WorkBudget* budget_;
  double points_ = 0.0;  // of all pairs
  int iterations_ = 0;
};

bool looksClean(const Candidate& candidate, const RobustBiasOptions& options) {
  return candidate.pruning.inlierFraction() >= options.clean_inlier_fraction &&
         candidate.score <= options.clean_cost;
}

}  // namespace

struct RobustBiasEstimator::State {
  const InitWindow& window;
  const RobustBiasOptions& options;
  const InertialOptions& inertial;
  ConsensusSearch consensus;
  Candidate best = {};
  GapRange gaps = consensus.gapsOf(kQuick);
  RobustBias found = {};

  // What follows from the best bias.
  RobustBias finish();
};

RobustBias RobustBiasEstimator::State::finish() {
  RobustBias out = found;
  MultiGapProblem& problem = consensus.problem();
  out.iterations = consensus.iterations();
  out.gyro_bias = best.minimum.gyro_bias;
  out.cost = best.score;
  if (!out.gyro_bias.allFinite() || out.gyro_bias.norm() > options.refinement.max_bias) {
    out.status = RobustBiasStatus::kOutOfRange;
    return out;
  }
  out.imu_noise = assumedImuNoise(window, inertial);
  const Baselines baselines =
      problem.baselinesAt(out.gyro_bias, gaps, best.minimum.weighted, best.minimum.baselines);
  out.rotations = freeRotations(problem.pairs(), problem.rotationsAt(out.gyro_bias, kShortGap),
                                baselines, kShortGap, out.clean ? kFreeFromClean : kFreeFromFar);
  out.track_sigma = trackNoise(problem.pairs(), out.rotations);
  out.readout = checkReadout(window, problem.pairs(), out.rotations, out.gyro_bias,
                             std::fmax(out.track_sigma, problem.pairs().sigma()));
  out.pruning = best.pruning;
  out.status = out.inlierFraction() < options.min_inlier_fraction ? RobustBiasStatus::kNoConsensus
                                                                  : RobustBiasStatus::kOk;
  return out;
}

RobustBiasEstimator::RobustBiasEstimator(const InitWindow& window,
                                         const std::vector<VanishingPoint>* vanishing_points,
                                         const RobustBiasOptions& options,
                                         const InertialOptions& inertial, WorkBudget* budget)
    : state_(new State{window, options, inertial,
                       ConsensusSearch(window, vanishing_points, options, inertial, budget)}) {}

RobustBiasEstimator::~RobustBiasEstimator() = default;

RobustBias RobustBiasEstimator::quick() {
  State& s = *state_;
  s.found.point_pairs = s.consensus.problem().pointPairs();
  s.found.vp_pairs = s.consensus.problem().vpPairs();
  if (s.found.point_pairs == 0) return s.found;
  s.best = s.consensus.refine(s.consensus.start(), kQuick);
  s.found.clean = looksClean(s.best, s.options);
  return s.finish();
}

RobustBias RobustBiasEstimator::thorough() {
  State& s = *state_;
  if (s.found.point_pairs == 0) return s.found;
  if (!s.consensus.mayGoOn()) return s.finish();
  s.gaps = s.consensus.gapsOf(kThorough);
  s.best = s.consensus.refine(s.best.minimum, kThorough);
  return s.finish();
}

RobustBias estimateRobustGyroBias(const InitWindow& window,
                                  const std::vector<VanishingPoint>* vanishing_points,
                                  const RobustBiasOptions& options, const InertialOptions& inertial,
                                  WorkBudget* budget) {
  RobustBiasEstimator estimator(window, vanishing_points, options, inertial, budget);
  const RobustBias bias = estimator.quick();
  return bias.clean ? bias : estimator.thorough();
}

}  // namespace slim_init
