// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "line_selection.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "lines/line_scene.h"

namespace slim_init::baselines {
namespace {

constexpr double kScoreTolerance = 1e-15;

struct Seen {
  FeatureId id;
  int keyframe;
  double length_px = 100.0;
  double detection_confidence = 1.0;
  double match_quality = 1.0;
};

std::shared_ptr<const InitWindow> windowOfObservations(const std::vector<Seen>& seen,
                                                       int keyframes) {
  std::vector<FrameObservation> frames(static_cast<std::size_t>(keyframes));
  for (int k = 0; k < keyframes; ++k) frames[k].t = 0.25 * k;
  for (const Seen& s : seen) {
    LineObservation line;
    line.id = s.id;
    // The length lets a test tell observations apart, the geometry does not matter here.
    line.start_bearing = Eigen::Vector3d(0.01 * static_cast<double>(s.id), 0.0, 1.0).normalized();
    line.end_bearing = Eigen::Vector3d(0.01 * static_cast<double>(s.id), 0.3, 1.0).normalized();
    line.length_px = s.length_px;
    line.detection_confidence = s.detection_confidence;
    line.match_quality = s.match_quality;
    frames[s.keyframe].lines.push_back(line);
  }
  return test::windowOf(frames);
}

std::vector<Seen> track(FeatureId id, const std::vector<int>& keyframes, double length_px = 100.0,
                        double confidence = 1.0, double match_quality = 1.0) {
  std::vector<Seen> seen;
  for (const int k : keyframes) seen.push_back({id, k, length_px, confidence, match_quality});
  return seen;
}

std::vector<Seen> all(const std::vector<std::vector<Seen>>& tracks) {
  std::vector<Seen> seen;
  for (const auto& one : tracks) seen.insert(seen.end(), one.begin(), one.end());
  return seen;
}

FeatureId idOfObservation(const InitWindow& window, int observation) {
  for (const Track& candidate : window.lineTracks()) {
    if (candidate.begin <= observation && observation < candidate.end) return candidate.id;
  }
  return -1;
}

std::vector<FeatureId> idsOf(const InitWindow& window, const std::vector<WeightedLine>& lines) {
  std::vector<FeatureId> ids;
  for (const WeightedLine& line : lines) {
    ids.push_back(idOfObservation(window, line.observation_i));
    EXPECT_EQ(ids.back(), idOfObservation(window, line.observation_j));
  }
  return ids;
}

TEST(LineSelection, ReliabilityIsTheMeanOfItsThreeParts) {
  // Seen in 4 of 10 keyframes, from 2 to 7: persistence 4/10, valid-match ratio 4/6.
  auto seen = track(7, {2, 3, 4, 7});
  seen[1].match_quality = 0.5;
  seen[2].match_quality = 0.9;
  const auto window = windowOfObservations(seen, 10);
  const Track& t = window->lineTracks().at(0);
  EXPECT_NEAR(trackReliability(*window, t, t.begin + 1), (0.4 + 0.5 + 4.0 / 6.0) / 3.0,
              kScoreTolerance);
  EXPECT_NEAR(trackReliability(*window, t, t.begin + 2), (0.4 + 0.9 + 4.0 / 6.0) / 3.0,
              kScoreTolerance);
}

TEST(LineSelection, ReliabilityIsOneForAPerfectTrackAndStaysInRange) {
  const auto perfect = windowOfObservations(track(1, {0, 1, 2, 3}), 4);
  EXPECT_NEAR(trackReliability(*perfect, perfect->lineTracks()[0], 1), 1.0, kScoreTolerance);
  const auto wild = windowOfObservations(track(1, {0, 1, 2, 3}, 100.0, 1.0, 17.0), 4);
  EXPECT_NEAR(trackReliability(*wild, wild->lineTracks()[0], 1), 1.0, kScoreTolerance);
  const auto bad = windowOfObservations(track(1, {0, 1, 2, 3}, 100.0, 1.0, -5.0), 4);
  EXPECT_NEAR(trackReliability(*bad, bad->lineTracks()[0], 1), 2.0 / 3.0, kScoreTolerance);
}

TEST(LineSelection, SaliencyIsTheMeanOfLengthAndConfidence) {
  LineSelectionOptions options;
  options.full_length_px = 200.0;
  const auto window = windowOfObservations(
      {{1, 0, 50.0, 0.6}, {1, 1, 200.0, 0.3}, {1, 2, 900.0, 1.7}, {1, 3, -4.0, -0.2}}, 4);
  EXPECT_NEAR(geometricSaliency(*window, 0, options), 0.5 * (0.25 + 0.6), kScoreTolerance);
  EXPECT_NEAR(geometricSaliency(*window, 1, options), 0.5 * (1.0 + 0.3), kScoreTolerance);
  EXPECT_NEAR(geometricSaliency(*window, 2, options), 1.0, kScoreTolerance);
  EXPECT_NEAR(geometricSaliency(*window, 3, options), 0.0, kScoreTolerance);
}

TEST(LineSelection, EveryConsecutivePairOfATrackIsSelectedOnce) {
  const auto window = windowOfObservations(track(3, {0, 1, 3, 4, 5}), 6);
  const auto pairs = selectLines(*window, {});
  ASSERT_EQ(pairs.size(), 5U);
  const std::vector<std::size_t> expected = {1, 0, 0, 1, 1};  // the gap at 2 takes two pairs
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_EQ(pairs[i].epipolar.size(), expected[i]) << "pair " << i;
    EXPECT_EQ(pairs[i].normal.size(), expected[i]) << "pair " << i;
    for (const WeightedLine& line : pairs[i].epipolar) {
      EXPECT_EQ(window->lineObservations()[line.observation_i].keyframe, static_cast<int>(i));
      EXPECT_EQ(window->lineObservations()[line.observation_j].keyframe, static_cast<int>(i) + 1);
    }
  }
}

TEST(LineSelection, WeightsAreThoseOfEquation13) {
  LineSelectionOptions options;
  options.full_length_px = 200.0;
  const auto window =
      windowOfObservations({{1, 0, 50.0, 0.6}, {1, 1, 100.0, 0.2, 0.7}, {1, 2, 1.0, 0.0, 0.1}}, 4);
  const auto pairs = selectLines(*window, options);
  // Persistence 3/4, valid-match ratio 3/3, match quality that of the later observation.
  EXPECT_NEAR(pairs[0].epipolar.at(0).weight, 0.5 + 0.5 * (0.75 + 0.7 + 1.0) / 3.0,
              kScoreTolerance);
  EXPECT_NEAR(pairs[1].epipolar.at(0).weight, 0.5 + 0.5 * (0.75 + 0.1 + 1.0) / 3.0,
              kScoreTolerance);
  // Length and confidence those of the earlier observation.
  EXPECT_NEAR(pairs[0].normal.at(0).weight, 0.5 + 0.5 * 0.5 * (0.25 + 0.6), kScoreTolerance);
  EXPECT_NEAR(pairs[1].normal.at(0).weight, 0.5 + 0.5 * 0.5 * (0.5 + 0.2), kScoreTolerance);
}

TEST(LineSelection, WeightsStayInRangeForAnyInput) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> wild(-2.0, 3.0);
  std::vector<Seen> seen;
  for (FeatureId id = 0; id < 30; ++id) {
    for (int k = 0; k < 6; ++k) {
      const double length_px = 200.0 * wild(random);
      const double confidence = wild(random);
      const double quality = wild(random);
      seen.push_back({id, k, length_px, confidence, quality});
    }
  }
  for (const PairLines& pair : selectLines(*windowOfObservations(seen, 6), {})) {
    ASSERT_EQ(pair.epipolar.size(), 10U);
    for (const auto* lines : {&pair.epipolar, &pair.normal}) {
      for (std::size_t i = 0; i < lines->size(); ++i) {
        EXPECT_GE((*lines)[i].weight, 0.5);
        EXPECT_LE((*lines)[i].weight, 1.0);
        if (i > 0) {
          EXPECT_LE((*lines)[i].weight, (*lines)[i - 1].weight) << "best first";
        }
      }
    }
  }
}

TEST(LineSelection, KindsAreRankedByTheirOwnScore) {
  LineSelectionOptions options;
  options.max_lines_per_pair = 1;
  const auto window = windowOfObservations(all({track(1, {0, 1, 2}, 180.0, 0.9, 0.2),    // salient
                                                track(2, {0, 1, 2}, 30.0, 0.3, 0.95)}),  // reliable
                                           3);
  const auto pairs = selectLines(*window, options);
  EXPECT_EQ(idsOf(*window, pairs[0].epipolar), (std::vector<FeatureId>{2}));
  EXPECT_EQ(idsOf(*window, pairs[0].normal), (std::vector<FeatureId>{1}));
}

TEST(LineSelection, TheBestLinesFillTheCap) {
  std::vector<std::vector<Seen>> tracks;
  for (FeatureId id = 0; id < 8; ++id) {
    tracks.push_back(track(id, {0, 1, 2}, 20.0 * static_cast<double>(id + 1), 0.5,
                           1.0 - 0.1 * static_cast<double>(id)));
  }
  const auto window = windowOfObservations(all(tracks), 3);
  LineSelectionOptions options;
  for (const int cap : {0, 3, 8, 100}) {
    options.max_lines_per_pair = cap;
    for (const PairLines& pair : selectLines(*window, options)) {
      EXPECT_EQ(pair.epipolar.size(), static_cast<std::size_t>(std::min(cap, 8)));
      EXPECT_EQ(pair.normal.size(), static_cast<std::size_t>(std::min(cap, 8)));
    }
  }
  options.max_lines_per_pair = 3;
  const auto pairs = selectLines(*window, options);
  EXPECT_EQ(idsOf(*window, pairs[1].epipolar), (std::vector<FeatureId>{0, 1, 2}));
  EXPECT_EQ(idsOf(*window, pairs[1].normal), (std::vector<FeatureId>{7, 6, 5}));
}

TEST(LineSelection, ShortTracksAreLeftOut) {
  const auto window =
      windowOfObservations(all({track(1, {0, 1}), track(2, {0, 1, 2}), track(3, {0, 1, 3})}), 4);
  LineSelectionOptions options;
  options.min_keyframes = 3;
  EXPECT_EQ(idsOf(*window, selectLines(*window, options)[0].epipolar),
            (std::vector<FeatureId>{2, 3}));
  options.min_keyframes = 2;
  // Persistence and valid-match ratio: track 2 3/4 and 1, track 1 2/4 and 1, track 3 3/4 and 3/4.
  EXPECT_EQ(idsOf(*window, selectLines(*window, options)[0].epipolar),
            (std::vector<FeatureId>{2, 1, 3}))
      << "1 and 3 are a tie";
  options.min_keyframes = 4;
  EXPECT_TRUE(selectLines(*window, options)[0].epipolar.empty());
}

TEST(LineSelection, TiesGoToTheLowerId) {
  std::vector<std::vector<Seen>> tracks;
  for (const FeatureId id : {42, 7, 1000, 3, 19}) tracks.push_back(track(id, {0, 1, 2}));
  LineSelectionOptions options;
  options.max_lines_per_pair = 3;
  const auto window = windowOfObservations(all(tracks), 3);
  const auto pairs = selectLines(*window, options);
  EXPECT_EQ(idsOf(*window, pairs[0].epipolar), (std::vector<FeatureId>{3, 7, 19}));
  EXPECT_EQ(idsOf(*window, pairs[0].normal), (std::vector<FeatureId>{3, 7, 19}));
}

}  // namespace
}  // namespace slim_init::baselines
