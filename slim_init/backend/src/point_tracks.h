// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Points of the window: the frames that observe them, and their distances.
#pragma once

#include <map>
#include <vector>

#include "slim_init/types.h"
#include "window.h"

namespace slim_init::backend {

struct PointView {
  FrameId frame = -1;
  Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();  ///< unit, in c
};

/// A track with the inverse distance along its first bearing, from that camera.
struct PointTrack {
  std::vector<PointView> views;   ///< in time order; the first is the host
  double inverse_distance = 0.0;  ///< [1/m]
  bool estimated = false;         ///< inverse_distance is a value
};

class PointTracks {
 public:
  using Map = std::map<FeatureId, PointTrack>;

  /// Adds the points of a new frame. Returns how many `previous` saw too.
  int addFrame(FrameId frame, FrameId previous, const std::vector<PointObservation>& points);

  /// Inverse distances of all tracks with two or more views that have none.
  void triangulate(const Frames& frames, const Calibration& calibration, double default_depth_m);
  /// Forgets all inverse distances.
  void forgetDistances();
  /// Removes tracks that came out behind their camera, by more than a point at infinity does by
  /// noise.
  void removeBehind();

  /// Removes what a frame saw; a track hosted there moves to its next view. The frame and that of
  /// the next view are in `frames`.
  void removeFrame(FrameId frame, const Frames& frames, const Calibration& calibration);

  /// Removes the first `count` views of a track, as removeFrame() does for one.
  static void removeViews(int count, const Frames& frames, const Calibration& calibration,
                          PointTrack* track);

  /// Mean motion between two frames of the tracks that both see, the rotation taken out [rad], and
  /// their number.
  struct Parallax {
    double mean = 0.0;
    int tracks = 0;
  };
  Parallax parallax(const Frame& i, const Frame& j, const Calibration& calibration) const;

  Map& tracks() { return tracks_; }
  const Map& tracks() const { return tracks_; }
  void clear() { tracks_.clear(); }

 private:
  Map tracks_;
};

}  // namespace slim_init::backend
