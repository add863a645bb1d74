// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What tests ask of the observations of a frame.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <vector>

#include "slim_init/types.h"

namespace slim_init {

inline auto fieldsOf(const PointObservation& o) {
  return std::tie(o.id, o.bearing, o.pixel, o.row);
}
inline auto fieldsOf(const LineObservation& o) {
  return std::tie(o.id, o.start_bearing, o.end_bearing, o.start_pixel, o.end_pixel, o.length_px,
                  o.detection_confidence, o.match_quality, o.start_row, o.end_row);
}

/// Equal to the last bit: all points, or all lines, of a frame.
template <typename Observation>
bool sameObservations(const std::vector<Observation>& a, const std::vector<Observation>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return fieldsOf(x) == fieldsOf(y); });
}

/// Equal to the last bit.
inline bool sameFrame(const FrameObservation& a, const FrameObservation& b) {
  return a.t == b.t && sameObservations(a.points, b.points) && sameObservations(a.lines, b.lines);
}

/// Ids in the order of the observations.
template <typename Observation>
std::vector<FeatureId> idsOf(const std::vector<Observation>& list) {
  std::vector<FeatureId> ids;
  for (const Observation& o : list) ids.push_back(o.id);
  return ids;
}
template <typename Observation>
std::set<FeatureId> idSet(const std::vector<Observation>& list) {
  const std::vector<FeatureId> ids = idsOf(list);
  return {ids.begin(), ids.end()};
}

/// How many of `list` have an id in `ids`.
template <typename Observation>
int countIn(const std::set<FeatureId>& ids, const std::vector<Observation>& list) {
  return static_cast<int>(std::count_if(
      list.begin(), list.end(), [&ids](const Observation& o) { return ids.count(o.id) > 0; }));
}

/// Every observation has the row of its pixel, in an image of this height.
inline void expectOwnRows(const FrameObservation& frame, int height) {
  for (const PointObservation& o : frame.points) EXPECT_EQ(o.row, imageRow(o.pixel.y(), height));
  for (const LineObservation& o : frame.lines) {
    EXPECT_EQ(o.start_row, imageRow(o.start_pixel.y(), height));
    EXPECT_EQ(o.end_row, imageRow(o.end_pixel.y(), height));
  }
}

}  // namespace slim_init
