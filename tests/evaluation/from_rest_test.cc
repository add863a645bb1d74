// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Which motions begin at rest, and the figures of their starts.
#include "slim_init/evaluation/from_rest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace slim_init::evaluation {
namespace {

// Ground truth at 20 Hz: stands still but for the spans of `moves`, in which it has 0.2 m/s.
Sequence sequenceThatMoves(double length, const std::vector<TimeSpan>& moves) {
  Sequence sequence;
  NavState state;
  for (int k = 0; k * 0.05 < length; ++k) {
    state.t = k * 0.05;
    const bool moving = std::any_of(moves.begin(), moves.end(), [&](const TimeSpan& span) {
      return state.t > span.first && state.t <= span.last;
    });
    if (moving) state.p_w_b.x() += 0.01;
    sequence.truth.push_back(state);
    FrameObservation frame;
    frame.t = state.t;
    sequence.frames.push_back(frame);
  }
  return sequence;
}

TEST(MotionOnsets, EveryRestOfASecondBeforeAMotion) {
  const std::vector<MotionOnset> onsets =
      motionOnsets(sequenceThatMoves(20.0, {{5.0, 7.0}, {9.0, 10.0}, {10.8, 12.0}}));
  // The rest of 0.8 s is too short.
  ASSERT_EQ(onsets.size(), 2u);
  EXPECT_NEAR(onsets[0].t, 5.1, 0.051);
  EXPECT_NEAR(0.05 * onsets[0].first, onsets[0].t - 3.0, 0.051);
  EXPECT_NEAR(onsets[1].t, 9.1, 0.051);
  EXPECT_NEAR(0.05 * onsets[1].first, 7.0, 0.051);
}

TEST(MotionOnsets, NoneWithoutRestOrMotionOrGroundTruth) {
  EXPECT_TRUE(motionOnsets(sequenceThatMoves(10.0, {})).empty());
  EXPECT_TRUE(motionOnsets(sequenceThatMoves(10.0, {{0.0, 10.0}})).empty());
  Sequence without = sequenceThatMoves(10.0, {{5.0, 7.0}});
  for (NavState& state : without.truth) state.t = kNotComputed;
  EXPECT_TRUE(motionOnsets(without).empty());
  EXPECT_TRUE(motionOnsets(Sequence()).empty());
}

FromRestRecord accepted(double after_s, double scale, double sigma) {
  FromRestRecord record;
  record.with_prior = record.from_rest = true;
  record.status = InitStatus::kSuccess;
  record.after_s = after_s;
  record.log_scale = std::log(scale);
  record.scale_sigma = sigma;
  return record;
}

TEST(FromRestTable, HasTheFiguresOfBothRuns) {
  FromRestRecord refused;
  refused.status = InitStatus::kScaleTooUncertain;
  FromRestRecord stood = accepted(0.4, 1.3, 0.3);
  stood.false_rests = 2;
  const std::string table =
      fromRestTable({accepted(0.2, 1.05, 0.05), stood, accepted(0.3, 0.97, 0.05), refused});
  EXPECT_NE(table.find("3 of 3 starts accepted"), std::string::npos) << table;
  EXPECT_NE(table.find("0.3 s median, 0.4 s p90"), std::string::npos) << table;
  EXPECT_NE(table.find("66.7 % within 10 %, 1 beyond 25 %"), std::string::npos) << table;
  EXPECT_NE(table.find("false rests 2"), std::string::npos) << table;
  EXPECT_NE(table.find("0 of 1 starts accepted"), std::string::npos) << table;
  const std::string csv = fromRestCsv({refused});
  EXPECT_NE(csv.find("scale_too_uncertain"), std::string::npos) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2);
}

TEST(RunFromRest, BadOptionsAreNamed) {
  InitializerOptions options;
  options.window.keyframes = 1;
  std::vector<FromRestRecord> records;
  EXPECT_NE(runFromRest(sequenceThatMoves(10.0, {{5.0, 7.0}}), options, &records), "");
}

}  // namespace
}  // namespace slim_init::evaluation
