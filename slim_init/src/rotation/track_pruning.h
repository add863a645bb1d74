// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Known-rotation pruning of point tracks: with the rotation from the gyro, two points fix the
// direction of translation between two keyframes, and every track that disagrees with it is wrong.
// Detects what a fundamental or an essential matrix accepts, since it has fewer degrees of freedom
// to fit: patches of repetitive texture that jump together by one period.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "data/with_observations.h"
#include "rotation/keyframe_pairs.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// Outcome of a pruning.
struct TrackPruning {
  /// One ObservationVerdict per observation, indexed as InitWindow::pointObservations().
  std::vector<char> keep;
  int checked = 0;       ///< consecutive observations of a track whose consistency could be tested
  int inconsistent = 0;  ///< those found inconsistent

  /// Share of the checked observations that agree; 1 when nothing could be checked.
  double inlierFraction() const {
    return checked > 0 ? 1.0 - static_cast<double>(inconsistent) / checked : 1.0;
  }
};

/// A pruning with the baselines that it found.
struct PairPruning {
  TrackPruning tracks;
  Baselines baselines;  ///< of the pairs of the checked gaps; as `known` for the others
};

/// Finds the translation direction of every keyframe pair of the checked gaps (1, 2 and 4) at
/// `rotations`, those of the gyro at a bias, and the observations that disagree with it by more
/// than `consensus.truncation_sigmas` standard deviations; the baselines `known` compete. A single
/// bad observation is dropped and its track continues; after a jump the rest of it is dropped.
/// Pairs that do not use their points are not tested, their observations are kept. Deterministic.
PairPruning pruneTracks(const InitWindow& window, const KeyframePairs& pairs,
                        const PairRotations& rotations, const ConsensusOptions& consensus,
                        Baselines known);

}  // namespace slim_init
