// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "line_selection.h"

#include <algorithm>

namespace slim_init::baselines {
namespace {

struct ScoredLine {
  double score = 0.0;  // q of eq. (13)
  int observation_i = -1;
  int observation_j = -1;
};

double clampToUnit(double value) { return std::clamp(value, 0.0, 1.0); }

// The best `max_lines`, best first. `scored` is in ascending order of track id, so a stable sort
// leaves equals to the lower id.
std::vector<WeightedLine> bestLines(std::vector<ScoredLine> scored, int max_lines) {
  std::stable_sort(scored.begin(), scored.end(),
                   [](const ScoredLine& a, const ScoredLine& b) { return a.score > b.score; });
  const std::size_t count =
      std::min(scored.size(), static_cast<std::size_t>(std::max(0, max_lines)));
  std::vector<WeightedLine> lines;
  lines.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    lines.push_back({scored[i].observation_i, scored[i].observation_j,
                     0.5 + 0.5 * clampToUnit(scored[i].score)});
  }
  return lines;
}

}  // namespace

double trackReliability(const InitWindow& window, const Track& track, int observation_j) {
  const std::vector<WindowLine>& observations = window.lineObservations();
  const double seen = track.size();
  const int span = observations[track.end - 1].keyframe - observations[track.begin].keyframe + 1;
  const double persistence = seen / window.size();
  const double match_quality = clampToUnit(observations[observation_j].match_quality);
  const double valid_match_ratio = seen / span;
  return (persistence + match_quality + valid_match_ratio) / 3.0;
}

double geometricSaliency(const InitWindow& window, int observation_i,
                         const LineSelectionOptions& options) {
  const WindowLine& observation = window.lineObservations()[observation_i];
  return 0.5 * (clampToUnit(observation.length_px / options.full_length_px) +
                clampToUnit(observation.detection_confidence));
}

std::vector<PairLines> selectLines(const InitWindow& window, const LineSelectionOptions& options) {
  const std::size_t pair_count = static_cast<std::size_t>(std::max(0, window.size() - 1));
  std::vector<std::vector<ScoredLine>> epipolar(pair_count);
  std::vector<std::vector<ScoredLine>> normal(pair_count);
  const std::vector<WindowLine>& observations = window.lineObservations();
  for (const Track& track : window.lineTracks()) {
    if (track.size() < options.min_keyframes) continue;
    for (int i = track.begin; i + 1 < track.end; ++i) {
      const int j = i + 1;
      const int keyframe = observations[i].keyframe;
      if (observations[j].keyframe != keyframe + 1) continue;
      epipolar[keyframe].push_back({trackReliability(window, track, j), i, j});
      normal[keyframe].push_back({geometricSaliency(window, i, options), i, j});
    }
  }
  std::vector<PairLines> pairs(pair_count);
  for (std::size_t i = 0; i < pair_count; ++i) {
    pairs[i].epipolar = bestLines(std::move(epipolar[i]), options.max_lines_per_pair);
    pairs[i].normal = bestLines(std::move(normal[i]), options.max_lines_per_pair);
  }
  return pairs;
}

}  // namespace slim_init::baselines
