// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// How good tracks are, where scene and camera path are known (docs/simulation.md, "Track quality").
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/simulation/rendering.h"
#include "slim_init/simulation/scene.h"
#include "slim_init/types.h"

namespace slim_init::simulation {

/// A point observation farther off is an outlier [px] (docs/simulation.md).
inline constexpr double kTrackOutlierPx = 1.5;
/// A line observation is the same line as at the keyframe before when both its ends lie within this
/// distance of it [px].
inline constexpr double kSameLinePx = 2.5;

/// One observation of a track after its first, against what was seen first.
struct PointError {
  FeatureId id = -1;
  int frame = 0;   ///< index in the order of addFrame()
  int age = 0;     ///< frames since the observation that it is measured against
  int solid = -1;  ///< index into Scene::solids of what the feature is taken to be on
  double error_px = kNotComputed;
  bool occluded = false;  ///< the true point is hidden or outside the image
};

/// One observation of a line track after its first, against what was seen first.
struct LineError {
  FeatureId id = -1;
  int frame = 0;
  int age = 0;
  int solid = -1;
  double angle_deg = kNotComputed;  ///< between the segment and the true line at its middle
  double offset_px = kNotComputed;  ///< of the segment's middle from the true line
  double end_px = kNotComputed;     ///< larger distance of the segment's ends from the true line
};

/// Errors of all tracks.
struct TrackQuality {
  int frames = 0;
  std::vector<PointError> points;           ///< against the first observation
  std::vector<PointError> keyframe_points;  ///< against the observation one interval earlier
  int point_tracks = 0;
  int point_tracks_without_truth = 0;  ///< their first ray meets nothing
  std::vector<LineError> lines;
  std::vector<LineError> keyframe_lines;
  int line_tracks = 0;
  /// On a curved surface, or on no single plane along their length.
  int line_tracks_without_truth = 0;
};

/// Collects frames, then measures every track.
class TrackTruth {
 public:
  TrackTruth(const Scene& scene, const feature_tracker_lines::CameraParameters& camera)
      : scene_(scene), camera_(camera) {}

  /// True pose of the camera as an image row (imageRow()) of a frame is exposed.
  using PoseAtRow = std::function<CameraPose(double row)>;

  /// Frames ascending in time. Every observation is taken at the pose of its own row.
  void addFrame(const FrameObservation& frame, const PoseAtRow& pose_at);

  TrackQuality evaluate() const;

 private:
  class Evaluation;
  /// Observations with the true poses at their times.
  struct SeenPoint {
    PointObservation seen;
    CameraPose pose;
  };
  struct SeenLine {
    LineObservation seen;
    CameraPose start_pose, end_pose;
  };
  struct View {
    double t = 0.0;
    std::vector<SeenPoint> points;
    std::vector<SeenLine> lines;
  };

  Scene scene_;
  feature_tracker_lines::Camera camera_;
  std::vector<View> views_;
};

}  // namespace slim_init::simulation
