// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/robust_bias.h"

#include <algorithm>
#include <utility>

#include "rotation/multi_gap_bias.h"

namespace slim_init {
namespace {

// The start is found at short gaps, where a bias still unknown turns the camera little.
constexpr int kStartGap = 2;
// Consensus cost is compared up to this gap: a wrong bias shows at long ones, where on the other
// hand the jumps of a track add up.
constexpr int kScoreGap = 4;
// A rival must be better than the noise of the consensus.
constexpr double kScoreMargin = 0.99;
constexpr double kTruncationSigmas = 3.0;
// The first pruning is at a bias that may be off by several residuals.
constexpr double kFirstPruning = 1.5;
// Two keyframes apart a camera has turned enough and the tracks have not yet drifted.
constexpr int kFreeGap = 2;

struct Candidate {
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  TrackPruning pruning;
  double score = 0.0;
};

class FrontDoor {
 public:
  FrontDoor(const InitWindow& window, const std::vector<VanishingPoint>* vanishing_points,
            const RobustBiasOptions& options)
      : options_(options), problem_(window, vanishing_points, options.refinement) {}

  MultiGapProblem& problem() { return problem_; }
  int iterations() const { return iterations_; }

  // Bias from short gaps, from `start`, with decreasing cutoffs from `cutoff`.
  Eigen::Vector3d approach(const Eigen::Vector3d& start, int gap, double cutoff) {
    problem_.keepOnly({});
    problem_.clearBaselines();
    problem_.findBaselines(start, gap, cutoff, hypotheses(), false);
    if (cutoff <= kTruncationSigmas) {
      return problem_.minimize(start, gap, {cutoff, cutoff}, &iterations_);
    }
    return problem_.minimize(start, gap, {cutoff, std::max(0.5 * cutoff, 3.0), 3.0}, &iterations_);
  }

  // Prune, minimise over all gaps, prune, minimise; thoroughly: once more, and with more rounds.
  Candidate refine(const Eigen::Vector3d& start, bool thorough) {
    const int max_gap = options_.refinement.max_gap;
    const double threshold = options_.pruning.threshold_sigmas;
    Candidate out;
    out.gyro_bias = start;
    problem_.useConsecutivePairs(thorough);
    for (int pass = 0; pass < (thorough ? 3 : 2); ++pass) {
      const double limit = pass == 0 ? kFirstPruning * threshold : threshold;
      out.pruning = problem_.prune(out.gyro_bias, limit, hypotheses(), !thorough);
      problem_.keepOnly(out.pruning.keep);
      if (thorough || pass == 0) {
        problem_.findBaselines(out.gyro_bias, max_gap, threshold, hypotheses(), !thorough);
      }
      const double cutoff = pass == 0 ? (thorough ? 5.0 : 4.0) : 3.0;
      out.gyro_bias = thorough
                          ? problem_.minimize(out.gyro_bias, max_gap, {cutoff, 3.0}, &iterations_)
                          : problem_.minimize(out.gyro_bias, max_gap, {cutoff}, &iterations_);
    }
    out.score = problem_.findBaselines(out.gyro_bias, kScoreGap, kTruncationSigmas,
                                       thorough ? hypotheses() : 0, false);
    return out;
  }

  // Masks, baselines and weights as refine() had them.
  void restore(const Candidate& candidate) {
    problem_.keepOnly(candidate.pruning.keep);
    problem_.clearBaselines();
    problem_.findBaselines(candidate.gyro_bias, options_.refinement.max_gap,
                           options_.pruning.threshold_sigmas, hypotheses(), false);
    problem_.refreshWeights(candidate.gyro_bias, options_.refinement.max_gap, kTruncationSigmas);
  }

 private:
  int hypotheses() const { return options_.pruning.hypotheses; }

  const RobustBiasOptions& options_;
  MultiGapProblem problem_;
  int iterations_ = 0;
};

}  // namespace

RobustBias estimateRobustGyroBias(const InitWindow& window,
                                  const std::vector<VanishingPoint>* vanishing_points,
                                  const RobustBiasOptions& options) {
  RobustBias out;
  FrontDoor door(window, vanishing_points, options);
  out.point_pairs = door.problem().pointPairs();
  out.vp_pairs = door.problem().vpPairs();
  if (out.point_pairs == 0) return out;

  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  Candidate best = door.refine(door.approach(zero, kStartGap, kTruncationSigmas), false);
  out.candidates = 1;
  const bool clean = best.pruning.inlierFraction() >= options.clean_inlier_fraction &&
                     best.score <= options.clean_cost;
  if (!clean && options.candidates > 0) {
    best = door.refine(best.gyro_bias, true);
    struct Approach {
      int gap;
      double cutoff;
    };
    for (const Approach& approach : {Approach{1, 3.0}, Approach{1, 8.0}, Approach{2, 16.0}}) {
      if (out.candidates > options.candidates) break;
      ++out.candidates;
      const Candidate next = door.refine(door.approach(zero, approach.gap, approach.cutoff), true);
      if (next.score < kScoreMargin * best.score) best = next;
    }
  }
  out.iterations = door.iterations();
  out.gyro_bias = best.gyro_bias;
  out.cost = best.score;
  if (!best.gyro_bias.allFinite() || best.gyro_bias.norm() > options.refinement.max_bias) {
    out.status = RobustBiasStatus::kOutOfRange;
    return out;
  }
  if (out.candidates > 1) door.restore(best);  // the weights are those of the last candidate
  out.information = door.problem().information(best.gyro_bias, options.gyro_noise_inflation);
  // Cutoffs in standard deviations; 40 are 24 px, what eight degrees of extrinsic rotation make of
  // a quick turn.
  out.rotations =
      clean ? door.problem().freeRotations(best.gyro_bias, kFreeGap, {kTruncationSigmas})
            : door.problem().freeRotations(best.gyro_bias, kFreeGap, {40.0, 12.0, 4.0, 3.0});
  out.pruning = std::move(best.pruning);
  out.status = out.inlierFraction() < options.min_inlier_fraction ? RobustBiasStatus::kNoConsensus
                                                                  : RobustBiasStatus::kOk;
  return out;
}

}  // namespace slim_init
