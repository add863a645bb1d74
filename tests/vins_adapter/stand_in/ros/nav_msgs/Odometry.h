// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/TwistWithCovarianceStamped.h>

namespace nav_msgs {
struct Odometry : geometry_msgs::TwistWithCovarianceStamped {};
}  // namespace nav_msgs
