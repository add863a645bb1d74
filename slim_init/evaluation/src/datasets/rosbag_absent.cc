// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// In place of rosbag.cc where that library was not found.
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence_writer.h"

namespace slim_init::evaluation {
namespace {

constexpr char kWithoutRosbag[] =
    " is a bag, and this build is without rosbag (install librosbag-storage-dev and "
    "libsensor-msgs-dev, or source a ROS installation, and configure again)";

}  // namespace

bool rosbagSupported() { return false; }

std::unique_ptr<ImageSequence> openRosbag(const std::string& file, const BagTopics& /*topics*/,
                                          const std::string& /*groundtruth_file*/,
                                          double /*max_imu_gap_s*/, ReadStatus* status) {
  *status = {file + kWithoutRosbag};
  return nullptr;
}

std::string writeBag(const std::string& /*asl_directory*/, const BagTopics& /*topics*/,
                     const std::string& file) {
  return file + kWithoutRosbag;
}

}  // namespace slim_init::evaluation
