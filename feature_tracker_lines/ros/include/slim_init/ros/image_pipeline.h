// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What feature_tracker_lines_node does between its messages: lets images wait for the IMU, tracks
// them, decides which are published. No ROS here.
#pragma once

#include <cstdint>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "slim_init/config/config.h"
#include "slim_init/feature_tracker_lines/image_front_end.h"
#include "slim_init/stream_check.h"

namespace slim_init::node {

/// When an image is tracked and when its features are published.
struct ImagePipelineOptions {
  /// Images that may wait for the IMU or for the processor; the oldest is dropped beyond.
  int image_queue = 20;
  /// An image that the IMU does not cover is tracked without it when another one this much newer
  /// has come [s]: IMU messages are late by some milliseconds, or do not come at all.
  double max_imu_wait_s = 0.5;
  /// Of published features [Hz]; 0: every image. The host's key `freq`.
  double publish_rate_hz = 10.0;

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// What became of the messages.
struct ImagePipelineCounts {
  std::int64_t images = 0;             ///< taken
  std::int64_t images_overrun = 0;     ///< dropped: image_queue was full
  std::int64_t images_before_imu = 0;  ///< dropped: older than the first IMU sample
  std::int64_t images_refused = 0;     ///< dropped by the front end (size, type)
  std::int64_t images_tracked = 0;
  std::int64_t images_without_imu = 0;  ///< of these, tracked without IMU
  std::int64_t frames_published = 0;
  std::int64_t observations_sideways = 0;  ///< not in the messages: 89.4 deg or more off axis
};

/// A tracked image to be published.
struct TrackedFrame {
  /// t as given to addImage(); what points forward only, and for a host that estimates td
  /// (Config::estimate_td) points with a velocity only.
  FrameObservation frame;
  FrameObservation previous;  ///< of the image tracked before, for velocities; t NaN: none
};

/// Images and IMU to frames, in the order and with the data that `slim_init ab` gives to the same
/// front end: up to the first sample at or after an image, images before the first sample dropped.
/// Stamps are the caller's; they pass a StreamCheck, for which a gap between images is a restart,
/// as in the host's tracker. Not thread-safe.
class ImagePipeline {
 public:
  /// Configuration and options as they are; call their validate() first.
  ImagePipeline(const Config& config, const ImagePipelineOptions& options);

  /// kRestarted: everything before is forgotten; ids go on, since a host may continue.
  AddStatus addImu(const ImuSample& sample);
  /// `t` [s] on the camera clock. `image` is kept until it is tracked and must not change.
  AddStatus addImage(double t, const cv::Mat& image);

  /// Tracks one image that is ready. `worked` says whether there was one; the frame is empty where
  /// it is not to be published: the first image after a start, images between two of the rate.
  std::optional<TrackedFrame> track(bool* worked);

  const feature_tracker_lines::ImageFrontEnd& frontEnd() const { return front_end_; }
  const ImagePipelineCounts& counts() const { return counts_; }
  const StreamCounts& streamCounts() const { return check_.counts(); }
  int waiting() const { return static_cast<int>(images_.size()); }
  /// Newest image and newest IMU sample, one less the other [s]; NaN before both have come.
  double imageAheadOfImu() const { return config_.calibration.imuTime(t_image_) - t_imu_; }

 private:
  struct PendingImage {
    double t = 0.0;  // camera clock
    cv::Mat image;
  };

  void forgetImages();
  void forgetImu();
  bool publishNow(double t);
  void keepForward(FrameObservation* frame);
  static void keepMoving(TrackedFrame* tracked);

  Config config_;
  ImagePipelineOptions options_;
  StreamCheck check_;
  feature_tracker_lines::ImageFrontEnd front_end_;
  std::deque<PendingImage> images_;
  std::deque<ImuSample> imu_;  // not yet with the front end
  double t_first_imu_ = kNotComputed;
  double t_fed_imu_ = kNotComputed;  // newest sample of the front end
  double t_imu_ = kNotComputed;      // newest of all
  double t_image_ = kNotComputed;
  double t_next_publish_ = kNotComputed;
  FrameObservation previous_;
  ImagePipelineCounts counts_;
};

}  // namespace slim_init::node
