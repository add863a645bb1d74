// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What both nodes do with a message before they use it, and what they say about it.
#include "slim_init/ros/node_streams.h"

#include <gtest/gtest.h>

#include <map>

#include "slim_init/ros/conversions.h"

namespace slim_init::node {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr std::uint32_t kStart = 1403636580;  // [s] since 1970

std_msgs::Header header(double t, std::uint32_t sequence = 0) {
  std_msgs::Header result;
  result.stamp = ros::Time(kStart) + ros::Duration(t);
  result.seq = sequence;
  return result;
}

std::map<std::string, std::string> valuesOf(const DiagnosticStatus& status) {
  std::map<std::string, std::string> values;
  for (const auto& pair : status.values) values[pair.key] = pair.value;
  return values;
}

class NodeStreamsTest : public ::testing::Test {
 protected:
  NodeStreamsTest() { ros::Time::init(); }  // no node here

  int restarts_ = 0;
  NodeStreams streams_{{{"imu"}, {"image", true, true}}, [this] { ++restarts_; }};
  double t_ = -1.0;
};

TEST_F(NodeStreamsTest, ClockBeginsWithTheFirstMessageOfAnyStream) {
  ASSERT_TRUE(streams_.accept(1, header(0.5), "", &t_));
  EXPECT_EQ(t_, 0.0);
  ASSERT_TRUE(streams_.accept(0, header(0.75), "", &t_));
  EXPECT_NEAR(t_, 0.25, 1e-9);
  EXPECT_EQ(streams_.clock().stampNs(t_), stampNs(header(0.75).stamp));
}

TEST_F(NodeStreamsTest, DropsAndCountsWhatCannotBeUsed) {
  const DiagnosticStatus before = streams_.report();
  EXPECT_EQ(before.level, DiagnosticStatus::OK);
  EXPECT_EQ(before.message, "data is coming");

  EXPECT_TRUE(streams_.accept(0, header(0.0, 1), "", &t_));
  EXPECT_FALSE(streams_.accept(0, header(0.1, 2), "a value is not finite", &t_));
  EXPECT_FALSE(streams_.accept(0, header(-0.1, 5), "", &t_));
  EXPECT_FALSE(streams_.accept(0, std_msgs::Header(), "", &t_));
  EXPECT_EQ(t_, 0.0) << "of the only message in use";
  EXPECT_EQ(streams_.received(0), 4);

  const DiagnosticStatus status = streams_.report();
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  auto values = valuesOf(status);
  EXPECT_EQ(values["imu received"], "4");
  EXPECT_EQ(values["imu lost on the way"], "2");
  EXPECT_EQ(values["imu dropped: garbage"], "1");
  EXPECT_EQ(values["imu dropped: late"], "1");
  EXPECT_EQ(values["imu dropped: no stamp"], "1");
  EXPECT_EQ(values["imu last garbage"], "a value is not finite");
  EXPECT_EQ(values["image received"], "0");
  // The warning takes the place of the good news, and goes when nothing more is dropped.
  EXPECT_EQ(status.message, "5 imu messages lost or dropped");
  EXPECT_EQ(streams_.report().message, "data is coming");
}

TEST_F(NodeStreamsTest, RestartsBeforeTheFirstMessageOfTheNewTime) {
  for (const double t : {10.0, 10.1, 10.2}) EXPECT_TRUE(streams_.accept(0, header(t), "", &t_));
  EXPECT_FALSE(streams_.accept(0, header(2.0), "", &t_));  // a stray stamp, or the jump
  EXPECT_EQ(restarts_, 0);
  EXPECT_TRUE(streams_.accept(0, header(2.1), "", &t_));
  EXPECT_EQ(restarts_, 1);
  EXPECT_EQ(streams_.jumps(), 1);
  EXPECT_NEAR(t_, -7.9, 1e-9) << "the clock goes on";
  // Forward: a restart only for the stream that asks for it.
  for (const double t : {20.0, 20.1}) streams_.accept(0, header(t), "", &t_);
  EXPECT_EQ(restarts_, 1);
  for (const double t : {20.0, 25.0, 25.1}) streams_.accept(1, header(t), "", &t_);
  EXPECT_EQ(restarts_, 2);
}

TEST(Diagnostics, RaisingNeverLowersAndKeepsEverySentence) {
  DiagnosticStatus status = makeStatus("part", "fine");
  raise(DiagnosticStatus::ERROR, "one", &status);
  raise(DiagnosticStatus::WARN, "two", &status);
  EXPECT_EQ(status.level, DiagnosticStatus::ERROR);
  EXPECT_EQ(status.message, "one; two");
}

}  // namespace
}  // namespace slim_init::node
