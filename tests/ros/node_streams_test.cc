// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What both nodes do with a message before they use it, and their diagnostics about it.
#include <gtest/gtest.h>

#include <map>

#include "slim_init/ros/conversions.h"
#include "slim_init/ros/stream_monitor.h"

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

  NodeStreams streams_{{{"imu", &StreamCounts::imu, true}, {"image", &StreamCounts::frames, true}}};
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
  StreamCounts counts;
  const DiagnosticStatus before = streams_.report(counts);
  EXPECT_EQ(before.level, DiagnosticStatus::OK);
  EXPECT_EQ(before.message, "data is coming");

  EXPECT_TRUE(streams_.accept(0, header(0.0, 1), "", &t_));
  EXPECT_FALSE(streams_.accept(0, header(0.1, 2), "a value is not finite", &t_));
  EXPECT_FALSE(streams_.accept(0, std_msgs::Header(), "", &t_));
  EXPECT_EQ(t_, 0.0) << "of the only message in use";
  EXPECT_EQ(streams_.received(0), 3);
  EXPECT_EQ(valuesOf(streams_.report(counts))["imu last discarded"], "the header has no stamp");

  // What StreamCheck has dropped since.
  EXPECT_TRUE(streams_.accept(0, header(0.2, 5), "", &t_));
  streams_.explain(0, "400 m/s^2 on an axis");
  counts.imu[AddStatus::kGlitch] = 1;
  counts.imu[AddStatus::kOutOfOrder] = 2;
  counts.imu[AddStatus::kStray] = 3;
  counts.imu[AddStatus::kBeforeJump] = 4;
  counts.frames[AddStatus::kOutOfOrder] = 5;
  const DiagnosticStatus status = streams_.report(counts);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  auto values = valuesOf(status);
  EXPECT_EQ(values["imu received"], "4");
  EXPECT_EQ(values["imu discarded: malformed"], "2");
  EXPECT_EQ(values["imu discarded: glitch"], "1");
  EXPECT_EQ(values["imu discarded: late"], "2");
  EXPECT_EQ(values["imu discarded: stray stamp"], "3");
  EXPECT_EQ(values["imu discarded: before a time jump"], "4");
  EXPECT_EQ(values["imu last discarded"], "400 m/s^2 on an axis");
  EXPECT_EQ(values["image received"], "0");
  EXPECT_EQ(values["image discarded: late"], "5");
  // The warning replaces the message of level OK until nothing more is dropped.
  EXPECT_NE(status.message.find("5 image messages lost or discarded"), std::string::npos)
      << status.message;
  EXPECT_EQ(streams_.report(counts).message, "data is coming");
}

TEST_F(NodeStreamsTest, LostMessagesAreThoseMissingInTheirNumbers) {
  const struct {
    std::vector<std::uint32_t> numbers;
    const char* lost;
  } cases[] = {{{1, 4}, "2"},
               {{7, 8, 11, 12}, "2"},
               {{7, 8, 11, 12, 0, 1}, "2"},  // the publisher started anew
               {{0xFFFFFFFFu, 1}, "1"},
               {{0, 0, 0, 0, 0}, "0"}};  // no count
  for (const auto& one : cases) {
    NodeStreams streams{{{"imu", &StreamCounts::imu, true}}};
    for (const std::uint32_t number : one.numbers) streams.accept(0, header(0.1, number), "", &t_);
    const DiagnosticStatus status = streams.report(StreamCounts());
    EXPECT_EQ(valuesOf(status)["imu lost"], one.lost);
    const bool none = one.lost[0] == '0';
    EXPECT_EQ(status.message,
              none ? "data is coming" : one.lost + std::string(" imu messages lost or discarded"));
  }
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
