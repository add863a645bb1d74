// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/track_pruning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "support/exact_window.h"
#include "support/robust_bias.h"

namespace slim_init {
namespace {

using Eigen::Vector3d;

// With the pairs up to `max_gap` keyframes apart; known is the baseline of the last one alone.
TrackPruning pruned(const InitWindow& window, const Vector3d& gyro_bias, int max_gap = kLongGap,
                    const Vector3d& last = Vector3d::Zero(), Baselines* found = nullptr) {
  const KeyframePairs pairs(window, max_gap);
  GyroRotations gyro(window);
  gyro.linearizeNear(atBias(gyro_bias));
  const PairRotations rotations = gyro.at(atBias(gyro_bias), pairs, kLongGap);
  Baselines unused, &baselines = found == nullptr ? unused : *found;
  baselines.assign(pairs.size(), Vector3d::Zero());
  baselines.back() = last;
  findBaselines(pairs, rotations, kLongGap, {kAgreementSigmas}, &baselines);
  return pruneTracks(window, pairs, rotations, kAgreementSigmas, &baselines);
}

// The first track of at least eight observations, so many of them displaced in both axes, from the
// fourth on.
struct Bent {
  std::shared_ptr<const InitWindow> window;
  Track track;

  Bent(const ExactWindow& exact, int observations) {
    const auto longEnough = [](const Track& t) { return t.size() >= 8; };
    const auto& tracks = exact.window->pointTracks();
    const FeatureId id = std::find_if(tracks.begin(), tracks.end(), longEnough)->id;
    std::vector<FrameObservation> frames = exact.keyframes;
    int seen = 0;
    for (FrameObservation& frame : frames) {
      for (PointObservation& point : frame.points) {
        if (point.id != id || seen++ < 3 || seen > 3 + observations) continue;
        shift(25.0, 25.0, exact.calibration.focal_px, &point);
      }
    }
    window = windowOf(exact, frames);
    for (const Track& t : window->pointTracks()) {
      if (t.id == id) track = t;
    }
  }
};

// After a single bad sighting the track goes on; what follows a jump is dropped as well.
TEST(TrackPruning, WhatIsDisplacedIsDropped) {
  for (const int displaced : {1, 100}) {
    const Bent bent(noisyWindow(Motion::kExcited, 2), displaced);
    const TrackPruning pruning = pruned(*bent.window, ExactWindowOptions().gyro_bias);
    for (int k = 0; k < bent.track.size(); ++k) {
      EXPECT_EQ(pruning.keep[bent.track.begin + k],
                k >= 3 && k < 3 + displaced ? kDropObservation : kKeepObservation)
          << displaced << ", " << k;
    }
  }
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
  const TrackPruning untested = pruned(*exact.window, wrong);
  EXPECT_EQ(untested.checked, 0);
  EXPECT_EQ(untested.keep, std::vector<char>(untested.keep.size(), kKeepObservation));
  EXPECT_EQ(untested.inlierFraction(), 1.0);
  few.points = 60;
  EXPECT_GT(pruned(*makeExactWindow(few).window, wrong).checked, 0);
}

TEST(TrackPruning, PairsOfLongerGapsChangeNothing) {
  const ExactWindow exact = noisyWindow(Motion::kExcited, 2);
  const Vector3d bias = ExactWindowOptions().gyro_bias;
  const TrackPruning alone = pruned(*exact.window, bias);
  // Pairs of more gaps than the pruning needs.
  const KeyframePairs pairs(*exact.window, 8);
  Baselines baselines;
  const TrackPruning shared = pruned(*exact.window, bias, 8, Vector3d::UnitY(), &baselines);
  EXPECT_EQ(shared.keep, alone.keep);
  ASSERT_EQ(pairs[pairs.size() - 1].gap(), 8);
  EXPECT_EQ(baselines.back(), Vector3d::UnitY()) << "beyond the checked gaps as handed in";
  EXPECT_GT(baselines.front().norm(), 0.0);
}

}  // namespace
}  // namespace slim_init
