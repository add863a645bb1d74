// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Recordings with pixels: ASL folders and rosbags behind one interface.
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "slim_init/evaluation/recorded.h"
#include "slim_init/types.h"

namespace slim_init::evaluation {

/// A recording with pixels. Everything but these is in memory; they are read one image at a time.
/// image_times may be shortened: images beyond it are not read. Not thread-safe.
class ImageSequence : public RecordedMotion {
 public:
  virtual ~ImageSequence() = default;
  ImageSequence(const ImageSequence&) = delete;
  ImageSequence& operator=(const ImageSequence&) = delete;

  /// Whether they can be decoded shows when they are read.
  std::size_t images() const { return image_times.size(); }
  /// Image k < images(), grey, CV_8UC1; colour is converted. An image that cannot be read is empty,
  /// and `error` (may be null) holds a sentence naming file or message and the reason. Never
  /// throws.
  virtual cv::Mat image(std::size_t k, std::string* error) = 0;

 protected:
  ImageSequence() = default;
};

/// Opens an ASL folder (EuRoC's layout): DIR/mav0 or DIR itself with imu0/data.csv, cam0/data.csv,
/// cam0/data/* and, where known,
/// state_groundtruth_estimate0/data.csv and speed0/data.csv. A step between IMU samples that is
/// longer than `max_imu_gap_s` is noted. On an error null, and `status` says what, where and which
/// bound (docs/evaluation.md, "Images").
std::unique_ptr<ImageSequence> openAslFolder(const std::string& directory, double max_imu_gap_s,
                                             ReadStatus* status);

/// Topics of a bag, as in `imu_topic`, `image_topic` and `speed_topic` of the host's file.
struct BagTopics {
  std::string imu = "/imu0";
  std::string image = "/cam0/image_raw";
  std::string speed;               ///< empty: none
  bool speed_forward_only = true;  ///< x alone is measured
};

/// Whether this build has the rosbag library.
bool rosbagSupported();

/// Opens a bag of ROS 1 (version 2.0): sensor_msgs/Imu, and sensor_msgs/Image (encodings of
/// image_message.h) or sensor_msgs/CompressedImage; velocities as
/// geometry_msgs/TwistWithCovarianceStamped or nav_msgs/Odometry. Times are those of the message
/// headers. The ground truth is read from `groundtruth_file`, columns as in an ASL folder; empty:
/// none. Neither a master nor any process of ROS is needed. On an error null, and a sentence in
/// `status`; in a build without rosbag always so.
std::unique_ptr<ImageSequence> openRosbag(const std::string& file, const BagTopics& topics,
                                          const std::string& groundtruth_file, double max_imu_gap_s,
                                          ReadStatus* status);

}  // namespace slim_init::evaluation
