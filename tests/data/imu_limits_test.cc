// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "slim_init/types.h"

namespace slim_init {
namespace {

using Eigen::Vector3d;

ImuSample sampleOf(const Vector3d& accel, const Vector3d& gyro) {
  ImuSample sample;
  sample.accel = accel;
  sample.gyro = gyro;
  return sample;
}

TEST(ImuLimits, CountForEachAxisInEitherDirection) {
  const ImuLimits limits;
  const Vector3d accel(-159.9, 159.9, 9.8), gyro(34.9, 0.0, -34.9);
  EXPECT_FALSE(limits.exceededBy(sampleOf(accel, gyro))) << "their norms are not what counts";
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vector3d beyond = accel;
      beyond[axis] = sign * 160.1;
      EXPECT_TRUE(limits.exceededBy(sampleOf(beyond, gyro))) << axis;
      beyond = gyro;
      beyond[axis] = sign * 35.1;
      EXPECT_TRUE(limits.exceededBy(sampleOf(accel, beyond))) << axis;
    }
  }
}

TEST(ImuLimits, WhatIsNoNumberIsAnotherDefect) {
  const double nan = kNotComputed, infinity = std::numeric_limits<double>::infinity();
  const ImuLimits limits;
  EXPECT_FALSE(limits.exceededBy(sampleOf(Vector3d(0, nan, 400), Vector3d(99, 0, 0))));
  EXPECT_FALSE(limits.exceededBy(sampleOf(Vector3d(0, 0, 400), Vector3d(0, infinity, 0))));
}

TEST(ImuLimits, AreTheUsers) {
  ImuLimits limits;
  limits.max_accel = 300.0;
  EXPECT_FALSE(limits.exceededBy(sampleOf(Vector3d(290, 0, 0), Vector3d::Zero())));
  EXPECT_TRUE(limits.exceededBy(sampleOf(Vector3d(310, 0, 0), Vector3d::Zero())));
  limits.max_accel = limits.max_gyro = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(limits.exceededBy(sampleOf(Vector3d(1e9, 0, 0), Vector3d(0, 1e9, 0))));
  EXPECT_EQ(limits.validate(), "");
}

TEST(ImuLimits, DescribeASampleAndTheLimits) {
  EXPECT_EQ(ImuLimits().describe(sampleOf(Vector3d(1, -412.3, 0), Vector3d(0, 0, -0.25))),
            "412 m/s^2 and 0.25 rad/s on an axis (limits 160 m/s^2, 35 rad/s)");
}

}  // namespace
}  // namespace slim_init
