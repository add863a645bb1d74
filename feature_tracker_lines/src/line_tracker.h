// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Tracks straight edges from image to image: predicted by KLT of points on them, confirmed by a
// detector, refitted to the edge.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "edge_fit.h"
#include "image_pyramid.h"
#include "line_detector.h"
#include "point_tracker.h"
#include "row_camera.h"
#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/feature_tracker_lines/image_front_end.h"
#include "slim_init/feature_tracker_lines/options.h"
#include "slim_init/types.h"

namespace slim_init::feature_tracker_lines {

/// A tracked line. Its rays are those of the middle row's exposure (RowCamera).
struct LineTrack {
  FeatureId id = -1;
  int age = 1;     ///< images it was found in
  int missed = 0;  ///< images in a row without a detection, this one included
  Edge edge;
  double confidence = 1.0;     ///< LineObservation::detection_confidence
  double match_quality = 1.0;  ///< LineObservation::match_quality
  /// Change of the normal since the previous image beyond what the rotation explains; from age 2
  /// on.
  Eigen::Vector3d normal_drift = Eigen::Vector3d::Zero();
};

/// A detected segment: rays of its ends, unit, in c, those of the middle row's exposure. The side
/// of start x end is the brighter one.
struct LineSegment {
  Eigen::Vector3d start, end;
  double length_px = 0.0;
  bool taken = false;  ///< by a tracked line
};

/// Detects and follows lines.
class LineTracker {
 public:
  /// KLT of points on lines: a smaller window than for corners [px], since the edge itself is what
  /// counts, as wide as OpenCV's vector loop. Pyramids need a border at least as wide.
  static constexpr int kWindowPx = 8;

  LineTracker(const CameraParameters& camera, const FrontEndOptions& options);

  /// Segments of the image `now`, the longest first. Does not touch the tracked lines.
  std::vector<LineSegment> detect(const ImagePyramid& now, const RotationPrior& prior);

  /// Tracks from `before` (empty for the first image) to `now`: prediction of the tracked lines,
  /// matching with the segments that detect() found in `now`, refit to the edge, new lines.
  /// `points`: motion of the points to `now`, which predicts that of new lines. Writes the line
  /// part of `report`.
  void track(const ImagePyramid& before, const ImagePyramid& now, const RotationPrior& prior,
             std::vector<LineSegment> segments, const PointMotion& points, ImageReport* report);

  /// Current lines: those tracked before by age and length, then the new ones by length.
  const std::vector<LineTrack>& tracks() const { return tracks_; }

  /// The camera of the last image.
  const RowCamera& lens() const { return lens_; }

  /// Segments of the detector in the last image [px], for display.
  const std::vector<cv::Vec4f>& detected() const { return detected_; }

  /// Forgets all lines. Ids are not reused.
  void reset();

 private:
  struct Prediction;
  struct Samples;
  struct Match;

  Samples sampleTracks(const RotationPrior& prior, const PointMotion& points) const;
  void followSamples(const ImagePyramid& before, const ImagePyramid& now,
                     const std::vector<std::size_t>& chosen, int levels, Samples* samples) const;
  Prediction fitSamples(const Samples& samples, std::size_t k, std::size_t first,
                        std::size_t last) const;
  std::vector<Prediction> predict(const ImagePyramid& before, const ImagePyramid& now,
                                  const RotationPrior& prior, const PointMotion& points) const;
  std::vector<Match> match(const std::vector<Prediction>& predictions,
                           const std::vector<LineSegment>& segments) const;
  bool follow(const ImagePyramid& now, const RotationPrior& prior, const Prediction& prediction,
              const Match& match, const std::vector<LineSegment>& segments, LineTrack* track) const;
  bool refit(const ImagePyramid& now, const Eigen::Vector3d& start, const Eigen::Vector3d& end,
             double search_px, Edge* edge) const;
  bool isSameLine(const Edge& a, const Edge& b, double max_distance_px) const;
  bool isTaken(const Edge& edge, double distance_px) const;
  void keepDistinct(std::vector<LineTrack> moved, ImageReport* report);
  void addNew(const ImagePyramid& now, const std::vector<LineSegment>& segments,
              ImageReport* report);

  Camera camera_;
  RowCamera lens_before_, lens_;  // of the image before and of the last one
  FrontEndOptions options_;
  double focal_px_ = 0.0;
  LineDetector detector_;
  std::vector<LineTrack> tracks_;
  std::vector<cv::Vec4f> detected_;
  FeatureId next_id_ = 0;
};

}  // namespace slim_init::feature_tracker_lines
