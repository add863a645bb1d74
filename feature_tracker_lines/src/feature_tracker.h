// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Points and lines of one image after another.
#pragma once

#include <opencv2/core.hpp>

#include "image_pyramid.h"
#include "line_tracker.h"
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
  FeatureTracker(const CameraParameters& camera, const FrontEndOptions& options);

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

  int halvings_;  // of the camera's image until the one that is tracked
  FrontEndOptions options_;
  PointTracker points_;
  LineTracker lines_;
  ImagePyramid before_, now_;
  cv::Mat equalized_;
  // Default profile: the image before as it came, and the factor on the grey levels of both.
  cv::Mat raw_;
  int gain_ = 1;
};

}  // namespace slim_init::feature_tracker_lines
