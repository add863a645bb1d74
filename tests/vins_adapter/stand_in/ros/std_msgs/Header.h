// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/ros.h>

namespace std_msgs {
struct Header {
  ros::Time stamp;
};
}  // namespace std_msgs
