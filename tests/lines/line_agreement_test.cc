// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "lines/line_track.h"
#include "support/exact_window.h"
#include "support/true_state.h"

namespace slim_init {
namespace {

constexpr double kMaxError = 6.0 * 0.7 / 458.0;
constexpr int kMinViews = 3;

// Lines that every keyframe of the window sees.
std::vector<FeatureId> alwaysSeen(const ExactWindow& exact) {
  std::vector<FeatureId> ids;
  for (const Track& track : exact.window->lineTracks()) {
    if (track.size() == exact.window->size()) ids.push_back(track.id);
  }
  return ids;
}

LineObservation* find(FrameObservation* frame, FeatureId id) {
  for (LineObservation& line : frame->lines) {
    if (line.id == id) return &line;
  }
  return nullptr;
}

// Of two lines that are always seen those that look least alike in the last keyframe.
std::pair<FeatureId, FeatureId> unlike(ExactWindow* exact) {
  std::pair<FeatureId, FeatureId> best = {-1, -1};
  double largest = 0.0;
  const std::vector<FeatureId> ids = alwaysSeen(*exact);
  for (const FeatureId a : ids) {
    for (const FeatureId b : ids) {
      const auto middle = [exact](FeatureId id) -> Eigen::Vector3d {
        const LineObservation* line = find(&exact->keyframes.back(), id);
        return line->start_bearing + line->end_bearing;
      };
      const double distance = (middle(a) - middle(b)).norm();
      if (distance <= largest) continue;
      largest = distance;
      best = {a, b};
    }
  }
  return best;
}

// From keyframe `from` to before `to` the line `id` shows what the line `other` shows.
void confuse(FeatureId id, FeatureId other, int from, int to, ExactWindow* exact) {
  for (int k = from; k < to; ++k) {
    const LineObservation shown = *find(&exact->keyframes[k], other);
    LineObservation* line = find(&exact->keyframes[k], id);
    line->start_bearing = shown.start_bearing;
    line->end_bearing = shown.end_bearing;
  }
  exact->window = windowOf(*exact);
}

int observationsOf(const std::vector<Track>& tracks) {
  int count = 0;
  for (const Track& track : tracks) count += track.size();
  return count;
}

TEST(LineAgreement, TrueLinesAreKeptWholeWithNoiseAndAtAnyScale) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const ExactWindow exact = makeExactWindow(seeded(seed, 0.7));
    for (const double scale : {1.0, 0.2, 5.0}) {
      WindowState state = trueState(exact);
      // The lever arm alone does not scale.
      for (int k = 0; k < state.size(); ++k) {
        const Eigen::Vector3d lever = state.R_b0_bk[k] * exact.calibration.t_b_c;
        state.p_b0.col(k) = scale * (state.p_b0.col(k) + lever) - lever;
      }
      const std::vector<Track> lines =
          agreeingLineTracks(*exact.window, state, kMaxError, kMinViews);
      int tracks = 0, observations = 0;
      for (const Track& track : exact.window->lineTracks()) {
        if (track.size() < kMinViews) continue;
        ++tracks;
        observations += track.size();
      }
      ASSERT_GT(tracks, 15);
      // A short segment now and then departs by that much from noise alone.
      EXPECT_NEAR(static_cast<int>(lines.size()), tracks, 2);
      EXPECT_GE(observationsOf(lines), 0.96 * observations);
    }
  }
}

// Pieces of the track of a line that shows another one from keyframe `from` on: first and last
// keyframe of each.
std::vector<std::pair<int, int>> piecesOfALineConfused(int from) {
  ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const auto [line, other] = unlike(&exact);
  EXPECT_GE(line, 0);
  confuse(line, other, from, 10, &exact);
  std::vector<std::pair<int, int>> pieces;
  for (const Track& track :
       agreeingLineTracks(*exact.window, trueState(exact), kMaxError, kMinViews)) {
    if (track.id != line) continue;
    pieces.emplace_back(exact.window->lineObservations()[track.begin].keyframe,
                        exact.window->lineObservations()[track.end - 1].keyframe);
  }
  return pieces;
}

TEST(LineAgreement, AConfusedLineIsCutWhereItJumps) {
  using Pieces = std::vector<std::pair<int, int>>;
  EXPECT_EQ(piecesOfALineConfused(6), (Pieces{{0, 5}, {6, 9}})) << "the longer one first";
  EXPECT_EQ(piecesOfALineConfused(8), (Pieces{{0, 7}})) << "two views are too few";
}

}  // namespace
}  // namespace slim_init
