// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Known-rotation pruning of point tracks: with the rotation from the gyro, two points fix the
// direction of translation between two keyframes, and every track that disagrees with it is wrong.
// Detects what a fundamental or an essential matrix accepts, since it has fewer degrees of freedom
// to fit: patches of repetitive texture that jump together by one period.
//
// And static tracks, points that are no part of the scene because they turn with the camera: parts
// of the vehicle in view, drops and dirt on the lens. Where rotation flow is parallel to an
// epipolar line, a point that lacks it has the image motion of some scene point, so that epipolar
// residuals do not find them (docs/derivation.md, 1.3).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "data/derived_window.h"
#include "rotation/keyframe_pairs.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// A point with a larger residual disagrees with the bias [sigma].
inline constexpr double kAgreementSigmas = 3.5;

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

/// Finds the observations that disagree by more than `threshold` standard deviations with the
/// translation direction of a keyframe pair of the checked gaps (1, 2 and 4) at `rotations`, those
/// of the gyro at a bias. `baselines`: as findBaselines() found them; those of the checked gaps are
/// moved to the best fit. A single bad observation is dropped and its track continues; after a jump
/// the rest of it is dropped. Pairs that do not use their points are not tested, their observations
/// are kept. Deterministic.
TrackPruning pruneTracks(const InitWindow& window, const KeyframePairs& pairs,
                         const PairRotations& rotations, double threshold, Baselines* baselines);

/// One entry per point track of `window`, nonzero where no observation is further than
/// kOutlierSigmas standard deviations of a bearing from their mean, although the rotation of the
/// camera at `gyro_bias` [rad/s] alone moves a far point by more than kTurnedSigmas after the first
/// one. All zero where more than kMaxStaticFraction of the tracks are such: then it is the rotation
/// that is wrong. Rows of a rolling shutter must not be compensated.
std::vector<char> staticTracks(const InitWindow& window, const Eigen::Vector3d& gyro_bias);

/// The window without staticTracks(), and their number in `static_tracks`. Null, and zero, where
/// they are less than kMinStaticFraction of all: robust weights bear with these, and a scene has
/// some too.
std::shared_ptr<const InitWindow> withoutStaticTracks(const InitWindow& window,
                                                      const Eigen::Vector3d& gyro_bias,
                                                      int* static_tracks);

}  // namespace slim_init
