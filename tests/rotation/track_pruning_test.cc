// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/track_pruning.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "rotation/constants.h"
#include "slim_init/options.h"
#include "support/exact_window.h"

namespace slim_init {
namespace {

using namespace testing_support;  // NOLINT: the vocabulary of these tests
using Eigen::Vector3d;

void shift(double dx_px, double dy_px, double focal_px, PointObservation* point) {
  const Vector3d f = point->bearing / point->bearing.z();
  point->bearing = (f + Vector3d(dx_px / focal_px, dy_px / focal_px, 0.0)).normalized();
}

// With the pairs and rotations that the pruning needs, and nothing known of the baselines.
TrackPruning pruned(const InitWindow& window, const Vector3d& gyro_bias,
                    int min_points_per_pair = 6) {
  const KeyframePairs pairs(window, rotation_constants::kLongGap, min_points_per_pair);
  GyroRotations gyro(window);
  gyro.linearizeNear(gyro_bias, rotation_constants::kRelinearizeTolerance);
  return pruneTracks(window, pairs, gyro.at(gyro_bias, pairs, rotation_constants::kLongGap),
                     {rotation_constants::kAgreementSigmas}, unknownBaselines(pairs))
      .tracks;
}

TEST(TrackPruning, SingleBadSightingIsDroppedAndTheTrackGoesOn) {
  const ExactWindow exact = noisyWindow(Motion::kExcited, 2);
  // A track of at least six observations, bent in the middle, in both axes.
  const InitWindow& clean = *exact.window;
  const auto track = std::find_if(clean.pointTracks().begin(), clean.pointTracks().end(),
                                  [](const Track& t) { return t.size() >= 6; });
  ASSERT_NE(track, clean.pointTracks().end());
  const int keyframe = clean.pointObservations()[track->begin + 3].keyframe;
  std::vector<FrameObservation> frames = exact.keyframes;
  for (PointObservation& point : frames[keyframe].points) {
    if (point.id == track->id) shift(25.0, 25.0, exact.calibration.focal_px, &point);
  }
  const auto window = windowOf(exact, frames);
  const TrackPruning pruning = pruned(*window, ExactWindowOptions().gyro_bias);
  const auto bent = std::find_if(window->pointTracks().begin(), window->pointTracks().end(),
                                 [&](const Track& t) { return t.id == track->id; });
  for (int a = bent->begin; a < bent->end; ++a) {
    const bool bad = window->pointObservations()[a].keyframe == keyframe;
    EXPECT_EQ(pruning.keep[a], bad ? kDropObservation : kKeepObservation) << a - bent->begin;
  }
}

TEST(TrackPruning, JumpForGoodCutsTheTrack) {
  const ExactWindow exact = noisyWindow(Motion::kExcited, 2);
  const InitWindow& clean = *exact.window;
  const auto track = std::find_if(clean.pointTracks().begin(), clean.pointTracks().end(),
                                  [](const Track& t) { return t.size() >= 8; });
  ASSERT_NE(track, clean.pointTracks().end());
  const int keyframe = clean.pointObservations()[track->begin + 4].keyframe;
  std::vector<FrameObservation> frames = exact.keyframes;
  for (std::size_t k = keyframe; k < frames.size(); ++k) {
    for (PointObservation& point : frames[k].points) {
      if (point.id == track->id) shift(25.0, 25.0, exact.calibration.focal_px, &point);
    }
  }
  const auto window = windowOf(exact, frames);
  const TrackPruning pruning = pruned(*window, ExactWindowOptions().gyro_bias);
  const auto bent = std::find_if(window->pointTracks().begin(), window->pointTracks().end(),
                                 [&](const Track& t) { return t.id == track->id; });
  EXPECT_EQ(pruning.keep[bent->begin + 4], kStartTrack);
  const auto cut = withObservations(*window, pruning.keep);
  ASSERT_NE(cut, nullptr);
  int pieces = 0;
  for (const Track& t : cut->pointTracks()) pieces += t.id == track->id ? 1 : 0;
  EXPECT_EQ(pieces, 2);
}

TEST(TrackPruning, AtTheTrueBiasCleanTracksStay) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const TrackPruning pruning = pruned(*exact.window, ExactWindowOptions().gyro_bias);
  EXPECT_GT(pruning.checked, 0);
  EXPECT_EQ(pruning.inconsistent, 0);
  EXPECT_EQ(pruning.keep, std::vector<char>(pruning.keep.size(), kKeepObservation));
  // A bias that is far off contradicts most of them.
  const Vector3d wrong = ExactWindowOptions().gyro_bias + Vector3d(0.5, -0.5, 0.5);
  const TrackPruning contradicted = pruned(*exact.window, wrong);
  EXPECT_LT(contradicted.inlierFraction(), 0.5);
  EXPECT_GT(std::count(contradicted.keep.begin(), contradicted.keep.end(), kDropObservation), 0);
}

TEST(TrackPruning, PairsWithFewPointsAreNotTested) {
  ExactWindowOptions few;
  few.points = 5;
  const ExactWindow exact = makeExactWindow(few);
  const Vector3d wrong = few.gyro_bias + Vector3d(0.5, -0.5, 0.5);
  const TrackPruning untested = pruned(*exact.window, wrong, 6);
  EXPECT_EQ(untested.checked, 0);
  EXPECT_EQ(untested.keep, std::vector<char>(untested.keep.size(), kKeepObservation));
  EXPECT_EQ(untested.inlierFraction(), 1.0);
  EXPECT_GT(pruned(*exact.window, wrong, 3).checked, 0);
}

TEST(TrackPruning, PairsOfLongerGapsChangeNothing) {
  const ExactWindow exact = noisyWindow(Motion::kExcited, 2);
  const Vector3d bias = ExactWindowOptions().gyro_bias;
  const TrackPruning alone = pruned(*exact.window, bias);
  // Pairs of more gaps than the pruning needs.
  const KeyframePairs pairs(*exact.window, 8, 6);
  GyroRotations gyro(*exact.window);
  gyro.linearizeNear(bias, rotation_constants::kRelinearizeTolerance);
  Baselines known = unknownBaselines(pairs);
  known.back() = Vector3d::UnitY();
  const PairPruning shared =
      pruneTracks(*exact.window, pairs, gyro.at(bias, pairs, rotation_constants::kLongGap),
                  {rotation_constants::kAgreementSigmas}, known);
  EXPECT_EQ(shared.tracks.keep, alone.keep);
  ASSERT_EQ(pairs[pairs.size() - 1].gap(), 8);
  EXPECT_EQ(shared.baselines.back(), Vector3d::UnitY()) << "beyond the checked gaps as handed in";
  EXPECT_GT(shared.baselines.front().norm(), 0.0);
}

}  // namespace
}  // namespace slim_init
