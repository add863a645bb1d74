// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/stream_check.h"

#include <gtest/gtest.h>

#include <limits>

namespace slim_init {
namespace {

ImuSample sampleAt(double t) {
  ImuSample sample;
  sample.t = t;
  sample.accel.z() = 9.81;
  return sample;
}

class LiveStreams : public ::testing::Test {
 protected:
  AddStatus imu(double t) { return check_.checkImu(sampleAt(t)); }
  AddStatus frame(double t) { return check_.checkFrame(t); }

  // Both streams from t on for `seconds`; every message has to be added.
  void play(double t, double seconds) {
    for (int k = 0; k <= static_cast<int>(200 * seconds); ++k) {
      EXPECT_EQ(imu(t + 0.005 * k), AddStatus::kAdded) << k;
      if (k % 10 == 0) {
        EXPECT_EQ(frame(t + 0.005 * k), AddStatus::kAdded) << k;
      }
    }
  }

  StreamCheck check_{StreamOptions::liveData()};
};

TEST_F(LiveStreams, OrderlyStreamsPass) {
  play(1e9, 3.0);
  EXPECT_EQ(check_.counts().imu.added(), 601);
  EXPECT_EQ(check_.counts().frames.added(), 61);
  EXPECT_EQ(check_.counts().imu[AddStatus::kOutOfOrder], 0);
  EXPECT_EQ(check_.counts().frames[AddStatus::kOutOfOrder], 0);
  EXPECT_EQ(check_.counts().restarts(), 0);
}

TEST_F(LiveStreams, ValuesThatAreNotFiniteAreDropped) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double t : {nan, HUGE_VAL}) {
    EXPECT_EQ(imu(t), AddStatus::kNotFinite) << t;
    EXPECT_EQ(frame(t), AddStatus::kNotFinite) << t;
  }
  ImuSample sample = sampleAt(1.0);
  sample.gyro.y() = nan;
  EXPECT_EQ(check_.checkImu(sample), AddStatus::kNotFinite);
  EXPECT_EQ(check_.counts().imu[AddStatus::kNotFinite], 3);
  EXPECT_EQ(check_.counts().frames[AddStatus::kNotFinite], 2);
  play(10.0, 0.5);
}

// Whatever the time: a glitch must not be taken for a jump.
TEST_F(LiveStreams, GlitchesAreDropped) {
  play(10.0, 1.0);
  ImuSample sample = sampleAt(11.002);
  sample.accel.x() = -160.1;
  for (const double t : {11.002, 2.0, 2.005}) {
    sample.t = t;
    EXPECT_EQ(check_.checkImu(sample), AddStatus::kGlitch) << t;
  }
  EXPECT_EQ(check_.counts().imu[AddStatus::kGlitch], 3);
  EXPECT_EQ(check_.counts().restarts(), 0);
  sample = sampleAt(11.005);
  sample.accel.x() = -159.9;
  EXPECT_EQ(check_.checkImu(sample), AddStatus::kAdded);
}

TEST_F(LiveStreams, LateAndRepeatedMessagesAreDropped) {
  play(10.0, 1.0);
  EXPECT_EQ(imu(11.0), AddStatus::kOutOfOrder);
  EXPECT_EQ(imu(10.2), AddStatus::kOutOfOrder);
  EXPECT_EQ(frame(11.0), AddStatus::kOutOfOrder);
  EXPECT_EQ(check_.counts().imu[AddStatus::kOutOfOrder], 2);
  EXPECT_EQ(check_.counts().frames[AddStatus::kOutOfOrder], 1);
  EXPECT_EQ(droppedSince(StreamCounts(), check_.counts()), "2 IMU samples (late), 1 frames (late)");
  EXPECT_EQ(droppedSince(check_.counts(), check_.counts()), "");
  EXPECT_EQ(imu(11.005), AddStatus::kAdded);
}

TEST_F(LiveStreams, AStrayStampCostsOneMessage) {
  play(10.0, 1.0);
  for (const double stray : {2.0, 13.0, 5000.0}) {
    EXPECT_EQ(imu(stray), AddStatus::kStray) << stray;
    EXPECT_EQ(frame(stray), AddStatus::kStray) << stray;
    EXPECT_EQ(imu(11.0 + 1e-4 * stray), AddStatus::kAdded);
    EXPECT_EQ(frame(11.0 + 1e-4 * stray), AddStatus::kAdded);
  }
  EXPECT_EQ(check_.counts().imu[AddStatus::kStray], 3);
  EXPECT_EQ(check_.counts().frames[AddStatus::kStray], 3);
  EXPECT_EQ(check_.counts().restarts(), 0);
}

TEST_F(LiveStreams, ABagThatStartsAgainIsOneRestart) {
  play(10.0, 3.0);
  EXPECT_EQ(imu(10.0), AddStatus::kStray);
  EXPECT_EQ(frame(10.0), AddStatus::kStray);
  EXPECT_EQ(imu(10.005), AddStatus::kRestarted);
  // An image of the old time was still on its way.
  EXPECT_EQ(frame(13.05), AddStatus::kBeforeJump);
  EXPECT_EQ(frame(10.05), AddStatus::kAdded);
  EXPECT_EQ(check_.counts().restarts(), 1);
  EXPECT_EQ(check_.counts().frames[AddStatus::kBeforeJump], 1);
  play(10.06, 2.0);
  EXPECT_EQ(check_.counts().restarts(), 1);
}

// A batch that was late is dropped; a clock that was set back by less than kJump is a restart.
TEST_F(LiveStreams, MessagesThatStayLateAreARestart) {
  play(10.0, 1.0);
  for (int k = 0; k < 10; ++k) EXPECT_EQ(imu(10.7 + 0.005 * k), AddStatus::kOutOfOrder) << k;
  EXPECT_EQ(imu(11.005), AddStatus::kAdded);
  for (int k = 0; k < 30; ++k) {
    EXPECT_EQ(imu(10.7), AddStatus::kOutOfOrder) << "one again and again is no clock";
  }
  EXPECT_EQ(check_.counts().restarts(), 0);
  EXPECT_EQ(imu(11.01), AddStatus::kAdded);
  EXPECT_EQ(frame(10.7), AddStatus::kOutOfOrder);
  EXPECT_EQ(frame(10.8), AddStatus::kRestarted);
  EXPECT_EQ(imu(11.015), AddStatus::kBeforeJump) << "it lags";
  play(10.81, 2.0);
  EXPECT_EQ(check_.counts().restarts(), 1);
}

TEST_F(LiveStreams, AGapIsConfirmedByEitherStream) {
  play(10.0, 1.0);
  EXPECT_EQ(imu(13.0), AddStatus::kStray);
  EXPECT_EQ(imu(13.005), AddStatus::kAdded);
  // The first image after the gap agrees with the IMU: nothing is lost.
  EXPECT_EQ(frame(13.01), AddStatus::kAdded);
  EXPECT_EQ(check_.counts().restarts(), 0);
}

TEST_F(LiveStreams, AGapBetweenFramesIsARestartForATracker) {
  StreamOptions options = StreamOptions::liveData();
  options.restart_on_frame_gap = true;
  check_ = StreamCheck(options);
  play(10.0, 1.0);
  imu(13.0);
  EXPECT_EQ(imu(13.005), AddStatus::kAdded);
  EXPECT_EQ(frame(13.0), AddStatus::kStray);
  EXPECT_EQ(frame(13.05), AddStatus::kRestarted);
  EXPECT_EQ(imu(13.06), AddStatus::kAdded);
  EXPECT_EQ(check_.counts().restarts(), 1);
}

TEST_F(LiveStreams, AStreamWithAClockOfItsOwnIsUsedAgainAfterAWhile) {
  play(10.0, 1.0);
  imu(5.0);
  ASSERT_EQ(imu(5.005), AddStatus::kRestarted);
  AddStatus status = AddStatus::kBeforeJump;
  for (int k = 1; k < 200 && status == AddStatus::kBeforeJump; ++k) status = frame(11.0 + 0.05 * k);
  EXPECT_EQ(status, AddStatus::kAdded);
  EXPECT_NEAR(check_.counts().frames[AddStatus::kBeforeJump], 100, 2);  // 5 s at 20 Hz
  EXPECT_EQ(check_.counts().restarts(), 1);
}

TEST_F(LiveStreams, ForgettingTheTimesKeepsTheCounts) {
  play(10.0, 1.0);
  check_.forgetTimes();
  EXPECT_EQ(check_.counts().imu.added(), 201);
  play(2.0, 0.1);
  EXPECT_EQ(check_.counts().restarts(), 0);
}

// A recording was sorted when it was read: gaps are gaps, and time never goes back.
TEST(RecordedStreams, OnlyTheOrderCounts) {
  StreamCheck check;
  EXPECT_EQ(check.checkImu(sampleAt(10.0)), AddStatus::kAdded);
  EXPECT_EQ(check.checkImu(sampleAt(5000.0)), AddStatus::kAdded);
  EXPECT_EQ(check.checkImu(sampleAt(11.0)), AddStatus::kOutOfOrder);
  EXPECT_EQ(check.checkImu(sampleAt(11.005)), AddStatus::kOutOfOrder);
  EXPECT_EQ(check.checkFrame(10.0), AddStatus::kAdded);
  EXPECT_EQ(check.checkFrame(20.0), AddStatus::kAdded);
  EXPECT_EQ(check.checkFrame(20.0), AddStatus::kOutOfOrder);
  EXPECT_EQ(check.counts().restarts(), 0);
}

TEST(StreamCountsTest, AddUp) {
  // Every field is a count: as an array of numbers.
  constexpr std::size_t kFields = sizeof(StreamCounts) / sizeof(std::int64_t);
  StreamCounts a, b;
  auto* fields_a = reinterpret_cast<std::int64_t*>(&a);
  auto* fields_b = reinterpret_cast<std::int64_t*>(&b);
  for (std::size_t i = 0; i < kFields; ++i) {
    fields_a[i] = static_cast<std::int64_t>(i);
    fields_b[i] = 100;
  }
  a += b;
  for (std::size_t i = 0; i < kFields; ++i) {
    EXPECT_EQ(fields_a[i], static_cast<std::int64_t>(100 + i)) << "field " << i;
  }
}

}  // namespace
}  // namespace slim_init
