// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/track_pruning.h"

#include <utility>

#include "rotation/constants.h"
#include "rotation/link_table.h"
#include "rotation/normalized_epipolar_pair.h"

namespace slim_init {

using namespace rotation_constants;  // NOLINT: the constants of this module

namespace {

// Verdicts on the links of a pair, of points with residuals in standard deviations.
void setLinks(const KeyframePair& pair, const PointResiduals& residuals, double threshold,
              LinkTable* links) {
  const double limit =
      threshold * threshold * (pair.gap() > kLongLinkGap ? kLongLinkInflation : 1.0);
  for (int k = 0; k < pair.points.count(); ++k) {
    links->set(pair.observation_i[k], pair.gap(), !(residuals.z2[k] > limit));
  }
}

}  // namespace

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
  PointResiduals residuals;
  int tested = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const KeyframePair& pair = pairs[p];
    const Eigen::Matrix3d& R = rotations[p].R_ci_cj;
    Eigen::Vector3d& baseline = out.baselines[p];
    if (!pair.use_points || pair.gap() > kMaxLinkGap || baseline.squaredNorm() == 0.0) continue;
    ++tested;
    // The winner of the draw went exactly through two noisy points.
    weighted.weigh(pair.points, all_points, R, baseline, pairs.sigma(), threshold, &residuals);
    baseline = weighted.baseline(R, baseline);
    pair.points.residuals(R, baseline, pairs.sigma(), &residuals);
    setLinks(pair, residuals, threshold, &links);
  }
  out.tracks = links.prune();
  out.tracks.pairs = tested;
  return out;
}

TrackPruning pruneTracks(const InitWindow& window, const WindowState& state, double sigma_rad,
                         double threshold_sigmas) {
  const Calibration& calibration = window.calibration();
  LinkTable links(window);
  PointResiduals residuals;
  int tested = 0;
  for (const KeyframePair& pair : KeyframePairs(window, kMaxLinkGap, 1)) {
    const Eigen::Vector3d baseline_b0 = cameraCentre(state, pair.j, calibration.t_b_c) -
                                        cameraCentre(state, pair.i, calibration.t_b_c);
    if (!pair.use_points || !(baseline_b0.norm() > 0.0)) continue;
    ++tested;
    const Eigen::Matrix3d R_ci_b0 = (state.R_b0_bk[pair.i] * calibration.R_b_c).transpose();
    pair.points.residuals(R_ci_b0 * state.R_b0_bk[pair.j] * calibration.R_b_c,
                          R_ci_b0 * baseline_b0.normalized(), sigma_rad, &residuals);
    setLinks(pair, residuals, threshold_sigmas, &links);
  }
  TrackPruning out = links.prune();
  out.pairs = tested;
  return out;
}

}  // namespace slim_init
