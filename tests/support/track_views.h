// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "estimation/visual_tracks.h"
#include "geometry/so3.h"
#include "lines/line_track.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// Views of a point track of `window` in the body frame, as the refinement makes them.
inline std::vector<PointView> pointViews(const InitWindow& window, const Track& track) {
  std::vector<PointView> views(track.size());
  for (int i = 0; i < track.size(); ++i) {
    const WindowPoint& seen = window.pointObservations()[track.begin + i];
    views[i].keyframe = seen.keyframe;
    views[i].bearing_b = window.calibration().R_b_c * seen.bearing;
    views[i].tangent_b = tangentBasis(views[i].bearing_b).transpose();
  }
  return views;
}

/// The same of a line track.
inline std::vector<LineView> lineViews(const InitWindow& window, const Track& track) {
  const Eigen::Matrix3d& R_b_c = window.calibration().R_b_c;
  std::vector<LineView> views;
  for (int s = track.begin; s < track.end; ++s) {
    const WindowLine& line = window.lineObservations()[s];
    views.push_back({line.keyframe, R_b_c * line.start_bearing, R_b_c * line.end_bearing});
  }
  return views;
}

}  // namespace slim_init
