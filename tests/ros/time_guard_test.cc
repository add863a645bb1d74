// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/time_guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "slim_init/ros/sequence_gaps.h"
#include "slim_init/ros/stamp_clock.h"

namespace slim_init::node {
namespace {

constexpr int kImu = 0, kImage = 1;

class TimeGuardTest : public ::testing::Test {
 protected:
  // Both streams from t on for `seconds`; every message has to be used, but `restart` may begin
  // them.
  void play(double t, double seconds) {
    for (int k = 0; k <= static_cast<int>(200 * seconds); ++k) {
      EXPECT_EQ(guard_.check(kImu, t + 0.005 * k), StampVerdict::kUse) << k;
      if (k % 10 == 0) {
        EXPECT_EQ(guard_.check(kImage, t + 0.005 * k), StampVerdict::kUse) << k;
      }
    }
  }

  TimeGuard guard_{{{false}, {true}}};
};

TEST_F(TimeGuardTest, OrderlyStreamsPass) {
  play(1e9, 3.0);
  EXPECT_EQ(guard_.counts(kImu).used, 601);
  EXPECT_EQ(guard_.counts(kImage).used, 61);
  EXPECT_EQ(guard_.counts(kImu).dropped() + guard_.counts(kImage).dropped(), 0);
  EXPECT_EQ(guard_.restarts(), 0);
}

TEST_F(TimeGuardTest, StampsThatAreNoneAreDropped) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double t : {0.0, -1.0, nan, HUGE_VAL}) {
    EXPECT_EQ(guard_.check(kImu, t), StampVerdict::kNoStamp) << t;
  }
  EXPECT_EQ(guard_.counts(kImu).no_stamp, 4);
  play(10.0, 0.5);
}

TEST_F(TimeGuardTest, LateAndRepeatedMessagesAreDropped) {
  play(10.0, 1.0);
  EXPECT_EQ(guard_.check(kImu, 11.0), StampVerdict::kLate);
  EXPECT_EQ(guard_.check(kImu, 10.2), StampVerdict::kLate);
  EXPECT_EQ(guard_.counts(kImu).late, 2);
  EXPECT_EQ(guard_.check(kImu, 11.005), StampVerdict::kUse);
}

TEST_F(TimeGuardTest, AStrayStampCostsOneMessage) {
  play(10.0, 1.0);
  for (const double stray : {5000.0, 2.0, 13.0}) {
    EXPECT_EQ(guard_.check(kImu, stray), StampVerdict::kHeld) << stray;
    EXPECT_EQ(guard_.check(kImage, stray), StampVerdict::kHeld) << stray;
    guard_.check(kImu, 11.0 + 1e-4 * stray);
    guard_.check(kImage, 11.0 + 1e-4 * stray);
  }
  EXPECT_EQ(guard_.counts(kImu).held, 3);
  EXPECT_EQ(guard_.restarts(), 0);
}

TEST_F(TimeGuardTest, ABagThatStartsAgainIsOneRestart) {
  play(10.0, 3.0);
  EXPECT_EQ(guard_.check(kImu, 10.0), StampVerdict::kHeld);
  EXPECT_EQ(guard_.check(kImage, 10.0), StampVerdict::kHeld);
  EXPECT_EQ(guard_.check(kImu, 10.005), StampVerdict::kRestart);
  // An image of the old time was still on its way.
  EXPECT_EQ(guard_.check(kImage, 13.05), StampVerdict::kStale);
  EXPECT_EQ(guard_.check(kImage, 10.05), StampVerdict::kUse);
  EXPECT_EQ(guard_.restarts(), 1);
  play(10.06, 2.0);
  EXPECT_EQ(guard_.restarts(), 1);
}

TEST_F(TimeGuardTest, AGapIsARestartOnlyWhereItIsAskedFor) {
  play(10.0, 1.0);
  EXPECT_EQ(guard_.check(kImu, 13.0), StampVerdict::kHeld);
  EXPECT_EQ(guard_.check(kImu, 13.005), StampVerdict::kUse);
  EXPECT_EQ(guard_.restarts(), 0);
  EXPECT_EQ(guard_.check(kImage, 13.0), StampVerdict::kHeld);
  EXPECT_EQ(guard_.check(kImage, 13.05), StampVerdict::kRestart);
  EXPECT_EQ(guard_.check(kImu, 13.06), StampVerdict::kUse);
  EXPECT_EQ(guard_.restarts(), 1);
}

TEST_F(TimeGuardTest, AStreamWithAClockOfItsOwnIsTakenBackAfterAWhile) {
  play(10.0, 1.0);
  guard_.check(kImu, 5.0);
  ASSERT_EQ(guard_.check(kImu, 5.005), StampVerdict::kRestart);
  int stale = 0;
  StampVerdict verdict = StampVerdict::kStale;
  for (int k = 1; k < 200 && verdict == StampVerdict::kStale; ++k) {
    verdict = guard_.check(kImage, 11.0 + 0.05 * k);
    if (verdict == StampVerdict::kStale) ++stale;
  }
  EXPECT_EQ(verdict, StampVerdict::kUse);
  EXPECT_NEAR(stale, 100, 2);  // 5 s at 20 Hz
  EXPECT_EQ(guard_.restarts(), 1);
}

TEST(SequenceGapsTest, CountsWhatIsMissingAndNotWhatIsNoCount) {
  SequenceGaps gaps;
  for (const std::uint32_t sequence : {7u, 8u, 11u, 12u}) gaps.add(sequence);
  EXPECT_EQ(gaps.lost(), 2);
  gaps.add(0);  // the publisher started anew
  gaps.add(1);
  EXPECT_EQ(gaps.lost(), 2);
  SequenceGaps wrapped;
  wrapped.add(0xFFFFFFFFu);
  wrapped.add(1);
  EXPECT_EQ(wrapped.lost(), 1);
  SequenceGaps constant;
  for (int i = 0; i < 5; ++i) constant.add(0);
  EXPECT_EQ(constant.lost(), 0);
}

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
