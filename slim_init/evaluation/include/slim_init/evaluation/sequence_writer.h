// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Writes what openAslFolder() and openRosbag() read.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/types.h"

namespace slim_init::evaluation {

/// Takes IMU samples, images and true states, each kind in the order of its stamps (kinds may be
/// mixed freely). Every call returns an empty string, or a sentence naming the file or the bound;
/// after a sentence the sequence is incomplete. Numbers are written so that they are read back bit
/// for bit; `t` of the samples and states is not used, the stamps are [ns].
class SequenceWriter {
 public:
  virtual ~SequenceWriter() = default;
  SequenceWriter(const SequenceWriter&) = delete;
  SequenceWriter& operator=(const SequenceWriter&) = delete;

  virtual std::string addImu(std::int64_t stamp_ns, const ImuSample& sample) = 0;
  /// velocity.x() and its standard deviation; other components are not written. There may be none.
  virtual std::string addSpeed(std::int64_t stamp_ns, const SpeedSample& sample) = 0;
  /// `image` is CV_8UC1, not empty; written without loss.
  virtual std::string addImage(std::int64_t stamp_ns, const cv::Mat& image) = 0;
  /// All fields finite; written with velocity and biases (17 columns).
  virtual std::string addTruth(std::int64_t stamp_ns, const NavState& state) = 0;
  /// Closes the files; to be called once, at the end.
  virtual std::string finish() = 0;

 protected:
  SequenceWriter() = default;
};

/// What goes into the sensor.yaml files of an ASL folder.
struct WriterRig {
  Calibration calibration;
  feature_tracker_lines::CameraParameters camera;
  double image_rate_hz = 20.0;
  double imu_rate_hz = 200.0;
  std::string comment = "simulated";  ///< of both sensors; one line
};

/// Writes DIR/mav0/{cam0,imu0,speed0,state_groundtruth_estimate0}; images as PNG files named by
/// their stamp. Makes the folders; files of the same name are replaced, but a folder that already
/// holds images is refused. Null and a sentence in `error` when that fails.
std::unique_ptr<SequenceWriter> makeAslWriter(const std::string& directory, const WriterRig& rig,
                                              std::string* error);

/// Writes a bag (not compressed) with sensor_msgs/Imu and sensor_msgs/Image (mono8), and speeds as
/// geometry_msgs/TwistWithCovarianceStamped on `topics.speed` or /speed0, header stamp and record
/// time alike, and the ground truth beside it as groundtruthFileOf(file). Stamps must fit
/// ros::Time: whole seconds below 2^32. Null and a sentence in `error` when the file cannot be
/// made, in a build without rosbag always.
std::unique_ptr<SequenceWriter> makeBagWriter(const std::string& file, const BagTopics& topics,
                                              std::string* error);

/// "<file>.groundtruth.csv"
std::string groundtruthFileOf(const std::string& bag_file);

}  // namespace slim_init::evaluation
