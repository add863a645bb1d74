// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/track_pruning.h"

#include <utility>

#include "rotation/constants.h"
#include "rotation/link_table.h"
#include "rotation/normalized_epipolar_pair.h"

namespace slim_init {

using namespace rotation_constants;  // NOLINT: the constants of this module

PairPruning pruneTracks(const InitWindow& window, const KeyframePairs& pairs,
                        const PairRotations& rotations, const ConsensusOptions& consensus,
                        Baselines known) {
  PairPruning out;
  out.baselines =
      findBaselines(pairs, rotations, kMaxLinkGap, consensus, std::move(known)).baselines;
  const double threshold = consensus.truncation_sigmas;
  const Eigen::ArrayXd all_points;
  LinkTable links(window);
  NormalizedEpipolarPair weighted;
  int tested = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const KeyframePair& pair = pairs[p];
    const Eigen::Matrix3d& R = rotations[p].R_ci_cj;
    Eigen::Vector3d& baseline = out.baselines[p];
    if (!pair.use_points || pair.gap() > kMaxLinkGap || baseline.squaredNorm() == 0.0) continue;
    ++tested;
    // The winner of the draw went exactly through two noisy points.
    weighted.weigh(pair.points, all_points, R, baseline, pairs.sigma(), threshold);
    baseline = weighted.baseline(R, baseline);
    const PointResiduals residuals = pair.points.residuals(R, baseline, pairs.sigma());
    const double limit =
        threshold * threshold * (pair.gap() > kLongLinkGap ? kLongLinkInflation : 1.0);
    for (int k = 0; k < pair.points.count(); ++k) {
      links.set(pair.observation_i[k], pair.gap(), !(residuals.z2[k] > limit));
    }
  }
  out.tracks = links.prune();
  out.tracks.pairs = tested;
  return out;
}

TrackPruning pruneTracks(const InitWindow& window, const Eigen::Vector3d& gyro_bias,
                         const RobustBiasOptions& options) {
  const KeyframePairs pairs(window, kMaxLinkGap, options.refinement.min_points_per_pair);
  GyroRotations gyro(window);
  gyro.linearizeNear(gyro_bias, kRoughTolerance);
  const ConsensusOptions consensus = {options.pruning.threshold_sigmas, options.pruning.hypotheses,
                                      BaselineSearch::kAlways};
  return pruneTracks(window, pairs, gyro.at(gyro_bias, pairs, kMaxLinkGap), consensus,
                     unknownBaselines(pairs))
      .tracks;
}

}  // namespace slim_init
