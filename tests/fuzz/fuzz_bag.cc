// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The bytes are changes to a bag: of the records, of their headers, of the index at the end.
#include <rosbag/bag.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>

#include <fstream>
#include <iterator>

#include "fuzz_target.h"
#include "sequence_check.h"
#include "slim_init/evaluation/image_sequence.h"

namespace {

std::string smallBag(const std::string& path) {
  {
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    for (int k = 0; k < 40; ++k) {
      const ros::Time stamp(100 + 0.01 * k);
      sensor_msgs::Imu imu;
      imu.header.stamp = stamp;
      imu.linear_acceleration.z = 9.81;
      bag.write("/imu0", stamp, imu);
      if (k % 10 != 5) continue;
      sensor_msgs::Image image;
      image.header.stamp = stamp;
      image.height = 4;
      image.width = image.step = 8;
      image.encoding = "mono8";
      image.data.assign(32, static_cast<unsigned char>(k));
      bag.write("/cam0/image_raw", stamp, image);
    }
  }
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const slim_init::fuzz::Folder folder;
  static const std::string good = smallBag(folder.file("good.bag"));
  slim_init::fuzz::Bytes bytes(data, size);
  folder.write("a.bag", slim_init::fuzz::edited(good, &bytes));
  slim_init::evaluation::ReadStatus status;
  const auto sequence =
      slim_init::evaluation::openRosbag(folder.file("a.bag"), {}, "", 0.05, &status);
  slim_init::fuzz::checkSequence(sequence.get(), status);
  return 0;
}
