// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "data/clean_frame.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace slim_init {
namespace {

bool normalizeBearing(Eigen::Vector3d& bearing) {
  const double norm = bearing.norm();
  if (!std::isfinite(norm) || norm < 1e-12) return false;
  // Left alone when it already is a unit vector, so that cleaning twice keeps the bytes.
  if (std::abs(norm - 1.0) > 1e-14) bearing /= norm;
  return true;
}

template <typename Observation, typename Usable>
void sortAndFilter(std::vector<Observation>& observations, const Usable& usable,
                   StreamCounts& counts) {
  observations.erase(std::remove_if(observations.begin(), observations.end(),
                                    [&](Observation& observation) { return !usable(observation); }),
                     observations.end());
  const auto by_id = [](const Observation& a, const Observation& b) { return a.id < b.id; };
  if (!std::is_sorted(observations.begin(), observations.end(), by_id)) {
    std::stable_sort(observations.begin(), observations.end(), by_id);
  }
  const auto last = std::unique(observations.begin(), observations.end(),
                                [](const auto& a, const auto& b) { return a.id == b.id; });
  counts.observations_duplicate_id += static_cast<int>(observations.end() - last);
  observations.erase(last, observations.end());
}

}  // namespace

void cleanFrame(FrameObservation& frame, StreamCounts& counts) {
  sortAndFilter(
      frame.points,
      [&counts](PointObservation& point) {
        if (normalizeBearing(point.bearing) && std::isfinite(point.row)) return true;
        ++counts.observations_not_finite;
        return false;
      },
      counts);
  cleanLines(frame.lines, counts);
}

void cleanLines(std::vector<LineObservation>& lines, StreamCounts& counts) {
  sortAndFilter(
      lines,
      [&counts](LineObservation& line) {
        if (!normalizeBearing(line.start_bearing) || !normalizeBearing(line.end_bearing) ||
            !std::isfinite(line.length_px) || !std::isfinite(line.detection_confidence) ||
            !std::isfinite(line.match_quality) || !std::isfinite(line.start_row) ||
            !std::isfinite(line.end_row)) {
          ++counts.observations_not_finite;
          return false;
        }
        if (line.start_bearing.cross(line.end_bearing).norm() < kMinLineAngle) {
          ++counts.lines_degenerate;
          return false;
        }
        return true;
      },
      counts);
}

}  // namespace slim_init
