// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <std_msgs/Header.h>

namespace sensor_msgs {
struct Vector3 {
  double x = 0.0, y = 0.0, z = 0.0;
};
struct Imu {
  std_msgs::Header header;
  Vector3 linear_acceleration, angular_velocity;
};
typedef std::shared_ptr<const Imu> ImuConstPtr;
}  // namespace sensor_msgs
