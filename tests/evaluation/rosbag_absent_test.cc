// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/options.h"
#include "support/text_parts.h"

namespace slim_init::evaluation {
namespace {

TEST(Rosbag, ABuildWithoutItSaysSo) {
  EXPECT_FALSE(rosbagSupported());
  ReadStatus status;
  EXPECT_EQ(openRosbag("x.bag", BagTopics(), "", WindowOptions().max_imu_gap_s, &status), nullptr);
  expectParts(status.message, "x.bag is a bag, and this build is without rosbag");
  EXPECT_EQ(writeBag("x", BagTopics(), "x.bag"), status.message);
}

}  // namespace
}  // namespace slim_init::evaluation
