// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <std_msgs/Header.h>

#include <array>

namespace geometry_msgs {
struct Vector3 {
  double x = 0.0, y = 0.0, z = 0.0;
};
struct Twist {
  Vector3 linear, angular;
};
struct TwistWithCovariance {
  Twist twist;
  std::array<double, 36> covariance{};
};
struct TwistWithCovarianceStamped {
  std_msgs::Header header;
  TwistWithCovariance twist;
};
}  // namespace geometry_msgs
