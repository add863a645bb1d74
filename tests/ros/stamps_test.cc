// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "slim_init/ros/stamp_clock.h"

namespace slim_init::node {
namespace {

TEST(StampClockTest, KeepsNanosecondsAndGoesBelowTheFirstStamp) {
  StampClock clock;
  const std::int64_t first = 1403715273262142976;
  EXPECT_EQ(clock.seconds(first), 0.0);
  EXPECT_DOUBLE_EQ(clock.seconds(first + 1), 1e-9);
  EXPECT_DOUBLE_EQ(clock.seconds(first - 2000000000), -2.0);
  for (const std::int64_t step : {1LL, 123456789LL, 86400123456789LL}) {
    EXPECT_EQ(clock.stampNs(clock.seconds(first + step)), first + step);
  }
}

}  // namespace
}  // namespace slim_init::node
