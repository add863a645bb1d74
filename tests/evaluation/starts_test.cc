// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Which motions begin at rest, and the figures of starts.
#include "slim_init/evaluation/starts.h"

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
  const std::vector<Start> onsets =
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

TEST(StartsEvery, OnesWithDataEnoughUpToTheLimit) {
  const Sequence sequence = sequenceThatMoves(10.0, {});  // 200 images
  EXPECT_EQ(startsEvery(40, 0, 2.0, sequence).size(), 4u);
  EXPECT_EQ(startsEvery(40, 3, 2.0, sequence).size(), 3u);
  EXPECT_EQ(startsEvery(40, 0, 1.9, sequence).back().first, 160u);
}

StartRecord answered(int start, double after_s, double scale, double sigma) {
  StartRecord record;
  record.start = start;
  record.status = InitStatus::kSuccess;
  record.first = true;
  record.after_s = after_s;
  record.errors.log_scale = std::log(scale);
  record.errors.log_scale_squared = std::pow(record.errors.log_scale / sigma, 2);
  record.errors.velocity = std::abs(record.errors.log_scale);
  return record;
}

TEST(StartsTable, HasTheFiguresOfTheFirstEstimates) {
  StartRecord refused;
  refused.status = InitStatus::kScaleTooUncertain;
  refused.false_rest = true;
  StartRecord later = answered(0, 0.5, 1.02, 0.02);
  later.first = false;
  StartRecord stood = answered(1, 0.4, 1.3, 0.3);
  stood.from_rest = true;
  stood.downstream.ran = true;
  stood.downstream.ate = 0.1;
  const std::vector<StartRecord> records = {answered(0, 0.2, 1.05, 0.05), later, stood,
                                            answered(2, 0.3, 0.97, 0.05), refused};
  const std::string table = startsTable("title", records, 4, 0.5);
  for (const char* part :
       {"title: 3 of 4, after 0.3 s median, 0.38 s p90", "0.262 maximum",
        "2 within 10 %, 1 beyond 25 %", "scale 0.834;", "estimates at 0.5 s: 1 of 4",
        "from the rest: 1; false rests 1", "1 of 1 end well"}) {
    EXPECT_NE(table.find(part), std::string::npos) << part << "\n" << table;
  }
  const std::string csv = startsCsv({refused});
  EXPECT_NE(csv.find("scale_too_uncertain"), std::string::npos) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2);
}

TEST(RunStarts, BadOptionsAreNamed) {
  StartRun run;
  run.initializer.window.keyframes = 1;
  std::vector<StartRecord> records;
  const Sequence sequence = sequenceThatMoves(10.0, {{5.0, 7.0}});
  EXPECT_NE(runStarts(sequence, motionOnsets(sequence), run, &records), "");
}

}  // namespace
}  // namespace slim_init::evaluation
