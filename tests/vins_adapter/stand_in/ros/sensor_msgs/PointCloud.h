// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <std_msgs/Header.h>

namespace sensor_msgs {
struct Point32 {
  float x = 0.0f, y = 0.0f, z = 0.0f;
};
struct ChannelFloat32 {
  std::string name;
  std::vector<float> values;
};
struct PointCloud {
  std_msgs::Header header;
  std::vector<Point32> points;
  std::vector<ChannelFloat32> channels;
};
typedef std::shared_ptr<const PointCloud> PointCloudConstPtr;
}  // namespace sensor_msgs
