// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/TwistWithCovarianceStamped.h>

namespace sensor_msgs {
struct Imu {
  std_msgs::Header header;
  geometry_msgs::Vector3 linear_acceleration, angular_velocity;
};
typedef std::shared_ptr<const Imu> ImuConstPtr;
}  // namespace sensor_msgs
