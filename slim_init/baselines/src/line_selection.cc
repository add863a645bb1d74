// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "line_selection.h"

#include <algorithm>

namespace slim_init::baselines {
namespace {

struct ScoredLine {
  double score = 0.0;  // q of eq. (13)
  int sighting_i = -1;
  int sighting_j = -1;
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
    lines.push_back(
        {scored[i].sighting_i, scored[i].sighting_j, 0.5 + 0.5 * clampToUnit(scored[i].score)});
  }
  return lines;
}

}  // namespace

double trackReliability(const InitWindow& window, const Track& track, int sighting_j) {
  const std::vector<LineSighting>& sightings = window.lineSightings();
  const double seen = track.size();
  const int span = sightings[track.end - 1].keyframe - sightings[track.begin].keyframe + 1;
  const double persistence = seen / window.size();
  const double match_quality = clampToUnit(sightings[sighting_j].match_quality);
  const double valid_match_ratio = seen / span;
  return (persistence + match_quality + valid_match_ratio) / 3.0;
}

double geometricSaliency(const InitWindow& window, int sighting_i,
                         const LineSelectionOptions& options) {
  const LineSighting& sighting = window.lineSightings()[sighting_i];
  return 0.5 * (clampToUnit(sighting.length_px / options.full_length_px) +
                clampToUnit(sighting.detection_confidence));
}

std::vector<PairLines> selectLines(const InitWindow& window, const LineSelectionOptions& options) {
  const std::size_t pair_count = static_cast<std::size_t>(std::max(0, window.size() - 1));
  std::vector<std::vector<ScoredLine>> epipolar(pair_count);
  std::vector<std::vector<ScoredLine>> normal(pair_count);
  const std::vector<LineSighting>& sightings = window.lineSightings();
  for (const Track& track : window.lineTracks()) {
    if (track.size() < options.min_keyframes) continue;
    for (int i = track.begin; i + 1 < track.end; ++i) {
      const int j = i + 1;
      const int keyframe = sightings[i].keyframe;
      if (sightings[j].keyframe != keyframe + 1) continue;
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
