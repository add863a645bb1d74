// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/track_pruning.h"

#include <algorithm>
#include <array>
#include <utility>

#include "rotation/constants.h"
#include "rotation/normalized_epipolar_pair.h"

namespace slim_init {
namespace {

using namespace rotation_constants;  // NOLINT: the constants of this module

// Which pairs of observations of a track agree with the motion of the camera, and what follows
// from it for the observations.
class LinkTable {
 public:
  explicit LinkTable(const InitWindow& window);

  // Verdict on the link from observation `a` to that of the same track `gap` keyframes later,
  // 1 <= gap <= kLongGap.
  void set(int a, int gap, bool agrees) { links_[a][gap] = agrees ? kAgrees : kDisagrees; }

  // Drops what does not agree with the observations before it.
  TrackPruning prune() const;

 private:
  enum Link : char { kUntested, kAgrees, kDisagrees };

  Link link(int a, int b) const;
  void pruneTrack(const Track& track, TrackPruning* out) const;
  bool slides(const Track& track, const TrackPruning& out) const;

  const InitWindow& window_;
  // By observation and gap.
  std::vector<std::array<Link, kLongGap + 1>> links_;
};

LinkTable::LinkTable(const InitWindow& window)
    : window_(window), links_(window.pointObservations().size()) {
  for (auto& row : links_) row.fill(kUntested);
}

LinkTable::Link LinkTable::link(int a, int b) const {
  const int gap = window_.pointObservations()[b].keyframe - window_.pointObservations()[a].keyframe;
  return gap <= kLongGap ? links_[a][gap] : kUntested;
}

// Most of the longest links between what is kept disagree: such a point slides slowly. Nothing is
// left of a track of a single observation either.
bool LinkTable::slides(const Track& track, const TrackPruning& out) const {
  const std::vector<WindowPoint>& s = window_.pointObservations();
  int kept = 0, agree = 0, disagree = 0;
  for (int a = track.begin; a < track.end; ++a) {
    if (out.keep[a] == kDropObservation) continue;
    ++kept;
    for (int b = a + 1; b < track.end && s[b].keyframe - s[a].keyframe <= kLongGap; ++b) {
      if (out.keep[b] == kDropObservation || s[b].keyframe - s[a].keyframe != kLongGap) continue;
      agree += link(a, b) == kAgrees ? 1 : 0;
      disagree += link(a, b) == kDisagrees ? 1 : 0;
    }
  }
  return kept < 2 || disagree > agree;
}

void LinkTable::pruneTrack(const Track& track, TrackPruning* out) const {
  int last = track.begin;  // that is kept
  for (int b = track.begin + 1; b < track.end; ++b) {
    const Link step = link(b - 1, b);
    if (step != kUntested) {
      ++out->checked;
      out->inconsistent += step == kDisagrees ? 1 : 0;
    }
    const Link with_last = link(last, b);
    if (with_last == kAgrees || (with_last == kUntested && last == b - 1)) {
      last = b;
    } else {
      out->keep[b] = kDropObservation;
    }
  }
  if (slides(track, *out)) {
    std::fill(out->keep.begin() + track.begin, out->keep.begin() + track.end, kDropObservation);
  }
}

TrackPruning LinkTable::prune() const {
  TrackPruning out;
  out.keep.assign(window_.pointObservations().size(), kKeepObservation);
  for (const Track& track : window_.pointTracks()) pruneTrack(track, &out);
  return out;
}

}  // namespace

PairPruning pruneTracks(const InitWindow& window, const KeyframePairs& pairs,
                        const PairRotations& rotations, const ConsensusOptions& consensus,
                        Baselines known) {
  PairPruning out;
  out.baselines = findBaselines(pairs, rotations, kLongGap, consensus, std::move(known)).baselines;
  const double threshold = consensus.truncation_sigmas;
  const Eigen::ArrayXd all_points;
  LinkTable links(window);
  NormalizedEpipolarPair weighted;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const KeyframePair& pair = pairs[p];
    const Eigen::Matrix3d& R = rotations[p].R_ci_cj;
    Eigen::Vector3d& baseline = out.baselines[p];
    if (!pair.use_points || pair.gap() > kLongGap || baseline.squaredNorm() == 0.0) continue;
    // The winner of the draw went exactly through two noisy points.
    weighted.weigh(pair.points, all_points, R, baseline, pairs.sigma(), threshold);
    baseline = weighted.baseline(R, baseline);
    const PointResiduals residuals = pair.points.residuals(R, baseline, pairs.sigma());
    const double limit =
        threshold * threshold * (pair.gap() > kShortGap ? kLongLinkInflation : 1.0);
    for (int k = 0; k < pair.points.count(); ++k) {
      links.set(pair.observation_i[k], pair.gap(), !(residuals.z2[k] > limit));
    }
  }
  out.tracks = links.prune();
  return out;
}

}  // namespace slim_init
