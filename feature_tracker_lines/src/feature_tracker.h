// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Points, lines and the dominant vanishing point of one image after another.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "image_pyramid.h"
#include "line_tracker.h"
#include "lines/vanishing_point.h"
#include "point_tracker.h"
#include "rotation_prior.h"
#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/feature_tracker_lines/image_front_end.h"
#include "slim_init/feature_tracker_lines/options.h"
#include "slim_init/types.h"

namespace slim_init::feature_tracker_lines {

/// Image and rotation in, observations out. Pyramids are built once per image and shared.
class FeatureTracker {
 public:
  /// `sigma_line_rad`: standard deviation of a line's end across it, for the covariance of the
  /// vanishing point [rad].
  FeatureTracker(const CameraParameters& camera, const FrontEndOptions& options,
                 double sigma_line_rad);

  /// Tracks into `grey` (CV_8UC1, of the camera's size). `prior` is the rotation since the image
  /// before. Fills points and lines of `frame`, and `report` except for the rotation and the gyro
  /// bias.
  void track(double t, const cv::Mat& grey, const RotationPrior& prior, FrameObservation* frame,
             ImageReport* report);

  /// See ImageFrontEnd::debugImage().
  cv::Mat debugImage() const;

  /// Forgets everything but the ids.
  void reset();

 private:
  void prepare(const cv::Mat& grey);
  void trackFeatures(double t, const RotationPrior& given, ImageReport* report);
  void brighten(const cv::Mat& grey);
  void build(const cv::Mat& grey, int gain, ImagePyramid* out);
  void writeObservations(FrameObservation* frame) const;
  std::vector<WindowLine> observations() const;
  VanishingPoint estimateNear(const std::vector<WindowLine>& lines,
                              const Eigen::Vector3d& predicted) const;
  void predictAxes(const RotationPrior& prior);
  void preferFollowedAxis(const std::vector<WindowLine>& observations, int followed_id);
  int rememberAxis();
  void trackVanishingPoint(const RotationPrior& prior, ImageReport* report);

  int halvings_;   // of the camera's image until the one that is tracked
  Camera camera_;  // of the image that is tracked
  FrontEndOptions options_;
  double sigma_line_rad_;
  PointTracker points_;
  LineTracker lines_;
  ImagePyramid before_, now_;
  cv::Mat equalized_;
  // Default profile: the image before as it came, and the factor on the grey levels of both.
  cv::Mat raw_;
  int gain_ = 1;

  // A physical axis whose vanishing point was dominant in some image.
  struct Axis {
    int id = 0;
    double unseen_s = 0.0;      // [s]
    Eigen::Vector3d direction;  // unit, in the camera now
  };
  std::vector<Axis> axes_;  // most recent first
  int next_axis_ = 0;
  VanishingPoint vp_;
};

}  // namespace slim_init::feature_tracker_lines
