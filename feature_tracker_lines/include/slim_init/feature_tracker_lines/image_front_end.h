// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Images and IMU in, FrameObservation out. The only path from pixels to features: the command line,
// the ROS node and the host adapter all use it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>

#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/feature_tracker_lines/options.h"
#include "slim_init/keyframe_window.h"
#include "slim_init/types.h"

namespace slim_init::feature_tracker_lines {

/// What `addImage` did with an image.
enum class ImageStatus {
  kTracked,     ///< a frame came out
  kNotFinite,   ///< time is NaN or infinite: dropped
  kOutOfOrder,  ///< time not after the previous image: dropped
  kBadImage,    ///< empty, of another size than the camera's, of a type not handled, or refused by
                ///< OpenCV: dropped
};

/// Stable lower-case name: "tracked", "not_finite", "out_of_order", "bad_image".
const char* toString(ImageStatus status);

/// Report on one tracked image.
struct ImageReport {
  double total_ms = 0.0;              ///< wall-clock time
  double image_noise = kNotComputed;  ///< standard deviation, of the tracked image [grey levels]
  bool rotation_from_gyro = false;    ///< the IMU covers the time since the previous image
  bool rotation_missing = false;  ///< a gyro rotation was requested, but the IMU does not cover it
  /// The rotation of the gyroscope explained far fewer points than another, or (as long as its bias
  /// is not known) predicted them worse, and was not used.
  bool rotation_overruled = false;
  /// Outliers were rejected and corners added; in profile `vins` only in the images that the host's
  /// tracker publishes.
  bool publishable = true;
  int points_tracked = 0;   ///< from the previous image, no outliers, not too close to others
  int points_outliers = 0;  ///< rejected by the outlier check
  int points_new = 0;       ///< corners added
  int lines_matched = 0;    ///< tracked lines found among the segments of the detector
  int lines_carried = 0;    ///< tracked lines not detected but found by their edge
  int lines_new = 0;        ///< lines added
  bool gyro_bias_known = false;
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// What VINS-Mono uses of a fisheye's image if it has no mask: 255 in a circle about the principal
/// point as wide as the image, otherwise 0 (CV_8UC1).
cv::Mat imageCircle(const CameraParameters& camera);

/// Rotation prediction from the gyro, point and line tracker, online gyro bias.
///
/// Feed the IMU up to an image's time (image stamp + Calibration::td) before the image; an image
/// that the IMU does not cover is tracked without prediction. Deterministic: equal
/// inputs give equal frames, whatever the number of OpenCV threads.
/// Not thread-safe.
class ImageFrontEnd {
 public:
  /// Does not check its arguments: call their validate() functions first.
  ImageFrontEnd(const CameraParameters& camera, const Calibration& calibration,
                const FrontEndOptions& options);
  ~ImageFrontEnd();
  ImageFrontEnd(ImageFrontEnd&&) noexcept;
  ImageFrontEnd& operator=(ImageFrontEnd&&) noexcept;

  /// Appends a sample; time must increase.
  AddStatus addImu(const ImuSample& sample);

  /// Tracks into an image. `t`: image stamp on the camera clock [s], must increase. `image`:
  /// CV_8UC1 or CV_8UC3 (BGR), of the camera's size; not kept. On kTracked `frame` (not null) is
  /// the observation, otherwise it is not changed.
  ImageStatus addImage(double t, const cv::Mat& image, FrameObservation* frame);

  /// Report on the last tracked image; default-constructed before the first one.
  const ImageReport& report() const;

  /// Drawing of the last image (CV_8UC3, BGR): points coloured by age, blue new to red old; lines
  /// grey detected, blue matched. Of the size that is tracked. Empty before the first image.
  cv::Mat debugImage() const;

  /// Forgets images, tracks, IMU, bias and report. Ids are not reused.
  void reset();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slim_init::feature_tracker_lines
