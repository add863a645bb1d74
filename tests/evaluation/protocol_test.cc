// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/protocol.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <set>
#include <thread>

#include "evaluation/circle_sequence.h"
#include "slim_init/evaluation/report.h"
#include "support/exact_window.h"
#include "support/text_parts.h"

namespace slim_init::evaluation {
namespace {

int trialsAccountedFor(const ProtocolCounts& c) {
  return c.windows + c.without_truth + c.not_evaluable + c.ended + c.interrupted + c.repeated +
         c.invalid;
}

class Protocol : public ::testing::Test {
 protected:
  const FakeSolver solver_ = makePerfectSolver("fake");
  ProtocolOptions options_;
};
using AnytimeProtocol = Protocol;
using ParallelProtocol = Protocol;

TEST_F(Protocol, StartsATrialEveryStrideAndCountsTheEnd) {
  // 10 s: 201 frames, 21 trials. A window takes 45 frame intervals, so the last start is frame 150.
  const Sequence sequence = makeCircleSequence(10.0);
  ProtocolResult result = runProtocol(sequence, {&solver_});
  EXPECT_EQ(result.counts.frames, 201);
  EXPECT_EQ(result.counts.trials, 21);
  EXPECT_EQ(result.counts.windows, 16);
  EXPECT_EQ(result.counts.ended, 5);
  EXPECT_EQ(trialsAccountedFor(result.counts), 21);
  ASSERT_EQ(result.windows.size(), 16u);
  for (std::size_t i = 0; i < result.windows.size(); ++i) {
    const WindowRecord& window = result.windows[i];
    EXPECT_EQ(window.trial, static_cast<int>(i));
    EXPECT_NEAR(window.t_start, 0.5 * static_cast<double>(i), 1e-12);
    EXPECT_EQ(window.t_start_ns, sequence.t0_ns + 500000000LL * static_cast<int>(i));
    EXPECT_EQ(window.keyframes, 10);
    EXPECT_NEAR(window.duration_s, 2.25, 1e-12);
    ASSERT_EQ(window.methods.size(), 1u);
    EXPECT_TRUE(window.methods[0].attempted());
    EXPECT_TRUE(window.methods[0].metrics.success()) << window.methods[0].metrics.failure;
    EXPECT_NEAR(window.methods[0].metrics.scale_error, 0.0, 1e-12);
    EXPECT_GE(window.methods[0].solve_ms, 0.0);
  }
}

TEST_F(Protocol, EveryMethodGetsTheSameWindow) {
  const Sequence sequence = makeCircleSequence(6.0);
  const FakeSolver first = makePerfectSolver("first");
  const FakeSolver second = makePerfectSolver("second");
  ProtocolResult result = runProtocol(sequence, {&first, &second});
  EXPECT_EQ(result.methods, (std::vector<std::string>{"first", "second"}));
  ASSERT_EQ(first.windows.size(), result.windows.size());
  // The same object: it is immutable, so the bytes are the same too.
  EXPECT_EQ(first.windows, second.windows);
  EXPECT_EQ(first.times, second.times);
}

TEST_F(Protocol, AWindowDoesNotDependOnWhatCameBefore) {
  const Sequence sequence = makeCircleSequence(6.0);
  const FakeSolver all = makePerfectSolver("all"), some = makePerfectSolver("some");
  runProtocol(sequence, {&all}, options_);
  options_.stride = 30;
  runProtocol(sequence, {&some}, options_);
  ASSERT_GE(some.times.size(), 2u);
  EXPECT_EQ(all.times[3], some.times[1]);
}

TEST_F(Protocol, HonoursKeyframesAndLimit) {
  const Sequence sequence = makeCircleSequence(10.0);
  options_.window.keyframes = 5;
  options_.window.min_keyframes = 4;  // smaller windows are possible but do not count
  options_.max_windows = 3;
  ProtocolResult result = runProtocol(sequence, {&solver_}, options_);
  EXPECT_EQ(result.counts.windows, 3);
  EXPECT_EQ(result.counts.trials, 3);
  for (const auto& times : solver_.times) EXPECT_EQ(times.size(), 5u);
}

TEST_F(Protocol, WindowsWithoutTruthAreCountedAndNotSolved) {
  Sequence sequence = makeCircleSequence(10.0);
  // Keyframes of the windows fall on every fifth frame from 0 on.
  hideTruth(5.0, &sequence);
  ProtocolResult result = runProtocol(sequence, {&solver_});
  // Starts 60, 70, 80, 90, 100 hold frame 100.
  EXPECT_EQ(result.counts.without_truth, 5);
  EXPECT_EQ(result.counts.windows, 11);
  EXPECT_EQ(solver_.windows.size(), 11u);
  EXPECT_EQ(trialsAccountedFor(result.counts), 21);
  for (const WindowRecord& window : result.windows) {
    EXPECT_TRUE(window.trial < 6 || window.trial > 10) << window.trial;
  }
}

TEST_F(Protocol, ImuGapInterruptsInsteadOfStretchingAWindow) {
  Sequence sequence = makeCircleSequence(12.0);
  sequence.imu = withGap(sequence.imu, 5.01, 5.2);
  ProtocolResult result = runProtocol(sequence, {&solver_});
  EXPECT_EQ(trialsAccountedFor(result.counts), result.counts.trials);
  std::set<double> starts;
  for (const auto& times : solver_.times) {
    EXPECT_FALSE(times.front() < 5.01 && times.back() > 5.2) << times.front();
    EXPECT_TRUE(starts.insert(times.front()).second) << "window solved twice";
  }
  EXPECT_GT(result.counts.repeated + result.counts.interrupted, 0);
}

// What is measured is what runs: the limits of the IMU hold for recordings as well.
TEST_F(Protocol, ImuGlitchesAreDroppedAndCounted) {
  Sequence sequence = makeCircleSequence(6.0);
  for (ImuSample& sample : sequence.imu) {
    if (std::abs(sample.t - 1.0) < 1e-3) sample.accel.y() = 400.0;
  }
  options_.max_windows = 1;
  ProtocolResult result = runProtocol(sequence, {&solver_}, options_);
  EXPECT_EQ(result.counts.windows, 1);
  EXPECT_EQ(result.dropped.imu[AddStatus::kGlitch], 1);

  options_.imu.max_accel = 500.0;
  result = runProtocol(sequence, {&solver_}, options_);
  EXPECT_EQ(result.dropped.imu[AddStatus::kGlitch], 0);
  // A step that no body makes is screened as it is in a host, within the limits too.
  for (ImuSample& sample : sequence.imu) {
    if (sample.accel.y() == 400.0) sample.accel.y() = 100.0;
  }
  options_.imu = ImuLimits();
  result = runProtocol(sequence, {&solver_}, options_);
  EXPECT_EQ(result.counts.windows, 1);
  EXPECT_EQ(result.dropped.imu[AddStatus::kGlitch], 1);
}

TEST_F(Protocol, LongFrameGapInterrupts) {
  Sequence sequence = makeCircleSequence(16.0);
  sequence.frames = withGap(sequence.frames, 3.0, 8.0);
  ProtocolResult result = runProtocol(sequence, {&solver_});
  EXPECT_GT(result.counts.interrupted, 0);
  EXPECT_GT(result.counts.windows, 8);
  for (const auto& times : solver_.times) EXPECT_NEAR(times.back() - times.front(), 2.25, 1e-9);
}

TEST_F(Protocol, TimeOffsetOfTheCameraIsRespected) {
  Sequence sequence = makeCircleSequence(6.0);
  sequence.calibration.td = 0.013;
  ProtocolResult result = runProtocol(sequence, {&solver_});
  ASSERT_FALSE(result.windows.empty());
  EXPECT_NEAR(result.windows[0].t_start, 0.013, 1e-12);
  EXPECT_NEAR(result.windows[0].methods[0].metrics.pose_rmse, 0.0, 1e-12);
}

TEST_F(Protocol, RefusalsWithAndWithoutEstimateAreKeptApart) {
  const Sequence sequence = makeCircleSequence(3.0);
  const FakeSolver refuses("refuses", [](const InitWindow& window) {
    InitResult result = perfectResult(window);
    result.status = InitStatus::kScaleTooUncertain;
    result.message = "scale sigma 0.2 is above 0.1";
    result.scale_sigma = 0.2;
    return result;
  });
  const FakeSolver waits("waits", [](const InitWindow&) {
    InitResult result;
    result.status = InitStatus::kTooFewTracks;
    result.message = "2 tracks (minimum 8)";
    return result;
  });
  ProtocolResult result = runProtocol(sequence, {&refuses, &waits});
  ASSERT_FALSE(result.windows.empty());
  const MethodRecord& refused = result.windows[0].methods[0];
  EXPECT_TRUE(refused.attempted());
  EXPECT_TRUE(refused.metrics.success());
  EXPECT_FALSE(refused.accepted());
  EXPECT_EQ(refused.answer.scale_sigma, 0.2);
  const MethodRecord& waiting = result.windows[0].methods[1];
  EXPECT_FALSE(waiting.attempted());
  EXPECT_FALSE(waiting.metrics.success());
  EXPECT_EQ(waiting.answer.message, "2 tracks (minimum 8)");
}

TEST_F(Protocol, WithoutDataThereIsNoWindow) {
  EXPECT_EQ(runProtocol(Sequence(), {&solver_}).counts.trials, 0);
}

TEST_F(Protocol, WithoutAnyTruthWindowsAreSolvedAndNotJudged) {
  Sequence sequence = makeCircleSequence(6.0);
  sequence.truth = nullptr;
  ProtocolResult result = runProtocol(sequence, {&solver_});
  EXPECT_FALSE(result.has_truth);
  ASSERT_EQ(result.windows.size(), 8u);
  for (const WindowRecord& window : result.windows) {
    EXPECT_EQ(window.methods[0].metrics.failure, "no ground truth");
    EXPECT_TRUE(window.methods[0].accepted());
  }
}

/// Knows the circle, and accepts windows of `enough` keyframes or more.
FakeSolver makePatientSolver(const std::string& name, int enough) {
  return FakeSolver(name, [enough](const InitWindow& window) {
    InitResult result = perfectResult(window);
    if (window.size() < enough) result.status = InitStatus::kScaleTooUncertain;
    return result;
  });
}

TEST_F(AnytimeProtocol, AWindowGrowsUntilTheMethodAccepts) {
  const Sequence sequence = makeCircleSequence(6.0);
  const FakeSolver early = makePatientSolver("early", 0);
  const FakeSolver later = makePatientSolver("later", 7);
  const FakeSolver never = makePatientSolver("never", 99);
  options_.first_keyframes = 4;
  ProtocolResult result = runProtocol(sequence, {&early, &later, &never}, options_);
  EXPECT_EQ(result.first_keyframes, 4);
  ASSERT_EQ(result.windows.size(), 8u);  // as many as without
  for (const WindowRecord& window : result.windows) {
    EXPECT_EQ(window.keyframes, 10);
    EXPECT_EQ(window.methods[0].keyframes, 4);
    EXPECT_NEAR(window.methods[0].data_s, 0.75, 1e-12);
    EXPECT_TRUE(window.methods[0].accepted());
    EXPECT_EQ(window.methods[1].keyframes, 7);
    EXPECT_NEAR(window.methods[1].data_s, 1.5, 1e-12);
    EXPECT_TRUE(window.methods[1].metrics.success());
    // The last answer, where none was accepted.
    EXPECT_EQ(window.methods[2].keyframes, 10);
    EXPECT_EQ(window.methods[2].answer.status, InitStatus::kScaleTooUncertain);
  }
  // Asked at every image: once a trial, from 0.75 to 1.5 s, and to 2.25 s.
  EXPECT_EQ(early.times.size(), 8u);
  EXPECT_EQ(later.times.size(), 8u * 16u);
  EXPECT_EQ(never.times.size(), 8u * 31u);
  for (std::size_t i = 0; i < 31; ++i) {
    EXPECT_EQ(never.times[i].size(), 4 + i / 5);
    EXPECT_NEAR(never.times[i].back(), 0.75 + 0.05 * static_cast<double>(i), 1e-9);
    EXPECT_TRUE(i % 5 != 0 || never.times[i].front() == 0.0) << i;
  }
}

TEST_F(AnytimeProtocol, AWindowGrowsToItsSpanWithAllItsKeyframes) {
  const FakeSolver never = makePatientSolver("never", 99);
  options_.window = WindowOptions();
  options_.first_keyframes = options_.window.min_keyframes;
  ProtocolResult result = runProtocol(makeCircleSequence(6.0), {&never}, options_);
  ASSERT_EQ(result.windows.size(), 7u);
  for (const WindowRecord& window : result.windows) {
    EXPECT_EQ(window.keyframes, 15);
    EXPECT_NEAR(window.duration_s, 3.0, 1e-9);
  }
  EXPECT_NEAR(never.times.front().back() - never.times.front().front(), 0.4, 1e-9);
  // Without growing only the full ones are asked for.
  const FakeSolver full = makePatientSolver("full", 0);
  options_.first_keyframes = 0;
  result = runProtocol(makeCircleSequence(6.0), {&full}, options_);
  ASSERT_EQ(full.times.size(), 7u);
  for (const auto& times : full.times) EXPECT_NEAR(times.back() - times.front(), 3.0, 1e-9);
}

TEST_F(AnytimeProtocol, AnAnswerIsJudgedByThoseBefore) {
  // Too small by half at every other pair of images before 1.2 s; always sure of itself.
  const FakeSolver solver("wavering", [](const InitWindow& window) {
    InitResult result = perfectResult(window);
    const long image = std::lround(window.times().back() / 0.05);
    if (image < 24 && image % 4 >= 2) {
      for (NavState& state : result.states) state.p_w_b *= 0.5;
    }
    result.scale_sigma = 0.05;
    GateValue gate;
    gate.name = GateName::kOther;
    gate.passed = gate.enforced = true;
    result.gates = {gate};
    return result;
  });
  const Sequence sequence = makeCircleSequence(6.0);
  options_.first_keyframes = 4;
  options_.max_windows = 1;
  ProtocolResult result = runProtocol(sequence, {&solver}, options_);
  ASSERT_EQ(result.windows.size(), 1u);
  // At 1.4 s those of 1.2 and 1.3 s agree: six keyframes, the oldest at 0.15 s.
  EXPECT_TRUE(result.windows[0].methods[0].accepted());
  EXPECT_EQ(result.windows[0].methods[0].keyframes, 6);
  EXPECT_NEAR(result.windows[0].methods[0].data_s, 1.25, 1e-9);
  // A window that does not grow is asked once.
  options_.first_keyframes = 0;
  result = runProtocol(sequence, {&solver}, options_);
  for (const WindowRecord& window : result.windows) EXPECT_TRUE(window.methods[0].accepted());
}

/// Answers and times that differ from window to window: successes, refusals and waits, with numbers
/// that no file format likes.
FakeSolver makeVariedSolver(const std::string& name, double factor = 1.0) {
  return FakeSolver(name, [factor](const InitWindow& window) {
    const double t = window.times().front();
    const int trial = static_cast<int>(std::lround(2.0 * t));  // one every half second
    std::this_thread::sleep_for(std::chrono::milliseconds((5 * trial) % 7));
    InitResult result;
    if (trial % 5 == 3) {
      result.status = InitStatus::kStationary;
      result.message = "stands, \"still\",\nat " + std::to_string(t);
      result.gyro_bias.setConstant(0.01 / 3.0);
      return result;
    }
    result = perfectResult(window);
    for (NavState& state : result.states) state.p_w_b *= 1.0 + 0.1 * factor * std::sin(3.0 * t);
    if (trial % 5 == 1) result.status = InitStatus::kInconsistentResiduals;
    result.scale_sigma = factor / (3.0 + trial);
    result.counts.point_tracks = 10 + trial;
    result.stages = {{"one", 0.1 * trial}, {"two", 0.5}};
    result.gates.resize(2);
    result.gates[0].value = std::sqrt(2.0) * t;
    result.gates[1].value = -0.0;
    result.gates[1].passed = result.gates[1].enforced = true;
    return result;
  });
}

TEST_F(ParallelProtocol, AnswersAndOrderDoNotDependOnTheThreads) {
  Sequence sequence = makeCircleSequence(15.0);
  hideTruth(7.5, &sequence);  // some trials are none
  std::vector<std::string> files;
  std::vector<std::vector<int>> progress;
  int total = 0;
  for (const int threads : {1, 2, 8}) {
    const FakeSolver first = makeVariedSolver("first"), second = makeVariedSolver("second", 2.0);
    ProtocolOptions options;
    options.threads = threads;
    options.first_keyframes = 6;
    options.downstream = [](const Sequence&, const Calibration&, const InitResult& answer) {
      DownstreamRecord record;
      record.ran = true;
      record.ate = 0.1 * answer.states.front().t;  // tells which answer it was
      return record;
    };
    progress.emplace_back();
    ProtocolResult result =
        runProtocol(sequence, {&first, &second}, options, [&](int done, int of) {
          progress.back().push_back(done);
          total = of;
        });
    EXPECT_GT(result.counts.without_truth, 0);
    EXPECT_EQ(trialsAccountedFor(result.counts), result.counts.trials);
    for (WindowRecord& window : result.windows) {
      for (MethodRecord& record : window.methods) record.solve_ms = record.solve_cpu_ms = 0.0;
    }
    const std::vector<MethodSummary> summaries = summarize(result);
    files.push_back(windowsCsv(RunInfo(), result) + summaryJson(RunInfo(), result, summaries));
  }
  EXPECT_EQ(files[0], files[1]);
  EXPECT_EQ(files[0], files[2]);
  EXPECT_EQ(progress[0], progress[1]);
  EXPECT_EQ(progress[0], progress[2]);
  for (std::size_t i = 0; i < progress[0].size(); ++i) {
    EXPECT_EQ(progress[0][i], static_cast<int>(i) + 1);
  }
  EXPECT_GT(total, 0);
  EXPECT_EQ(static_cast<int>(progress[0].size()), total);
}

TEST_F(ParallelProtocol, SolvesAsManyWindowsAtOnceAsItHasThreads) {
  std::atomic<int> inside{0}, most{0};
  const FakeSolver solver("meets", [&](const InitWindow&) {
    most = std::max<int>(most, ++inside);
    // Waits for the others: one after the other they would meet nobody.
    for (int ms = 0; ms < 10000 && most < 3; ++ms) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    --inside;
    return InitResult();
  });
  options_.threads = 3;
  runProtocol(makeCircleSequence(6.0), {&solver}, options_);
  EXPECT_EQ(most, 3);
}

TEST_F(ParallelProtocol, TheLimitIsThatOfOneThread) {
  const FakeSolver solver = makeVariedSolver("fake");
  options_.threads = 4;
  options_.max_windows = 3;
  ProtocolResult result = runProtocol(makeCircleSequence(10.0), {&solver}, options_);
  EXPECT_EQ(result.counts.trials, 3);
  EXPECT_EQ(result.windows.size(), 3u);
  EXPECT_EQ(solver.windows.size(), 3u);
}

TEST_F(Protocol, CpuTimeCountsWorkAndNotSleep) {
  const FakeSolver works("works", [](const InitWindow&) {
    volatile double sum = 0.0;
    for (int i = 0; i < 4000000; ++i) sum = sum + std::sqrt(static_cast<double>(i));
    return InitResult();
  });
  const FakeSolver sleeps("sleeps", [](const InitWindow&) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return InitResult();
  });
  for (const int threads : {1, 2}) {
    ProtocolOptions options;
    options.threads = threads;
    options.max_windows = 1;
    const ProtocolResult result = runProtocol(makeCircleSequence(3.0), {&works, &sleeps}, options);
    const MethodRecord &work = result.windows[0].methods[0], &sleep = result.windows[0].methods[1];
    EXPECT_GT(work.solve_cpu_ms, 1.0);
    EXPECT_LT(work.solve_cpu_ms, 1.01 * work.solve_ms + 0.1);
    EXPECT_GE(sleep.solve_ms, 50.0);
    EXPECT_LT(sleep.solve_cpu_ms, 5.0);
  }
}

}  // namespace
}  // namespace slim_init::evaluation
