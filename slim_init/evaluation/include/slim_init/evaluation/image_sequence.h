// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Recordings with pixels: ASL folders and rosbags behind one interface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "slim_init/evaluation/recorded.h"
#include "slim_init/types.h"

namespace slim_init::evaluation {

/// A recording with pixels. All times are relative to the first IMU sample, [s]; the nanoseconds
/// are subtracted as integers. Everything but the pixels is in memory; those are read one image at
/// a time. Not thread-safe.
class ImageSequence {
 public:
  virtual ~ImageSequence() = default;
  ImageSequence(const ImageSequence&) = delete;
  ImageSequence& operator=(const ImageSequence&) = delete;

  /// The last component of the folder's or file's name that says something.
  const std::string& name() const { return name_; }
  /// Stamp of t = 0, the first IMU sample [ns].
  std::int64_t t0Ns() const { return t0_ns_; }
  const std::vector<ImuSample>& imu() const { return imu_; }  ///< ascending in time

  /// Measured velocities, where there are any; ascending in time.
  const std::vector<SpeedSample>& speeds() const { return speeds_; }

  /// Leaves out the images after the first `count`.
  void keepImages(std::size_t count) { image_stamps_ns_.resize(count); }

  /// Puts another IMU in place of the recorded one, ascending in time on the same clock.
  void replaceImu(std::vector<ImuSample> imu) { imu_ = std::move(imu); }

  /// At the times of the ground truth, ascending; empty without ground truth. Without
  /// hasVelocityAndBias() v_w_b is that of deriveVelocities() and the biases are NaN.
  const std::vector<NavState>& truth() const { return truth_; }
  bool hasVelocityAndBias() const { return has_velocity_and_bias_; }  ///< recorded

  /// Those kept; whether they can be decoded shows when they are read.
  std::size_t images() const { return image_stamps_ns_.size(); }
  /// Camera clock, ascending; before 0 when images start before the IMU.
  double imageTime(std::size_t k) const {
    return 1e-9 * static_cast<double>(image_stamps_ns_[k] - t0_ns_);
  }
  std::int64_t imageStampNs(std::size_t k) const { return image_stamps_ns_[k]; }

  /// Image k < images(), grey, CV_8UC1; colour is converted. An image that cannot be read is empty,
  /// and `error` (may be null) holds a sentence naming file or message and the reason. Never
  /// throws.
  virtual cv::Mat image(std::size_t k, std::string* error) = 0;

  const Disorder& imuDisorder() const { return imu_disorder_; }
  const Disorder& imageDisorder() const { return image_disorder_; }
  /// One sentence per thing dropped or suspicious.
  const std::vector<std::string>& notes() const { return notes_; }

 protected:
  ImageSequence() = default;

  std::string name_;
  std::int64_t t0_ns_ = 0;
  std::vector<ImuSample> imu_;
  std::vector<SpeedSample> speeds_;
  std::vector<NavState> truth_;
  bool has_velocity_and_bias_ = false;
  std::vector<std::int64_t> image_stamps_ns_;
  Disorder imu_disorder_, image_disorder_;
  std::vector<std::string> notes_;
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
