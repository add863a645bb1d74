// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Writes what openAslFolder() and openRosbag() read. Every call returns an empty string, or a
// sentence naming the file or the bound.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/types.h"

namespace slim_init::evaluation {

/// What goes into the sensor.yaml files of an ASL folder.
struct WriterRig {
  Calibration calibration;
  feature_tracker_lines::CameraParameters camera;
  std::string comment = "simulated";  ///< of both sensors; one line
};

/// Writes DIR/mav0/{cam0,imu0,state_groundtruth_estimate0} and, with speeds, speed0, without the
/// images that it names. Numbers are read back bit for bit; the ground truth has velocity and
/// biases, all finite, the speeds velocity.x() and its standard deviation. Makes the folders; files
/// of the same name are replaced, but a folder that already holds images is refused.
std::string writeAslFolder(const std::string& directory, const WriterRig& rig,
                           const RecordedMotion& recording);
/// An image of that folder, CV_8UC1, as a PNG file named by its stamp.
std::string writeAslImage(const std::string& directory, std::int64_t stamp_ns,
                          const cv::Mat& image);

/// Writes such a folder as a bag (not compressed) with sensor_msgs/Imu and sensor_msgs/Image
/// (mono8), and speeds as geometry_msgs/TwistWithCovarianceStamped on `topics.speed` or /speed0,
/// header stamp and record time alike, and the ground truth beside it as groundtruthFileOf(file).
/// Stamps must fit ros::Time: whole seconds below 2^32. In a build without rosbag always a
/// sentence.
std::string writeBag(const std::string& asl_directory, const BagTopics& topics,
                     const std::string& file);

/// "<file>.groundtruth.csv"
std::string groundtruthFileOf(const std::string& bag_file);

}  // namespace slim_init::evaluation
