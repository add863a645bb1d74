// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/keyframe_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/text_parts.h"

namespace slim_init {
namespace {

// Feeds 200 Hz IMU and 20 Hz frames with one point, both from t_begin to t_end.
class KeyframeWindowTest : public ::testing::Test {
 protected:
  static ImuSample imu(double t) {
    return {t, Eigen::Vector3d::Zero(), Eigen::Vector3d(0, 0, 9.8)};
  }
  static FrameObservation frame(double t) {
    FrameObservation f;
    f.t = t;
    PointObservation point;
    point.id = 1;
    f.points.push_back(point);
    return f;
  }
  static void feed(KeyframeWindow& window, double t_begin, double t_end, int frame_every = 10) {
    for (int k = 0; t_begin + k * 0.005 <= t_end + 1e-9; ++k) {
      window.addImu(imu(t_begin + k * 0.005));
      if (k % frame_every == 0) window.addFrame(frame(t_begin + k * 0.005));
    }
  }
  KeyframeWindow fed(double t_end) const {
    KeyframeWindow window(calibration_, options_);
    feed(window, 0.0, t_end);
    return window;
  }
  static WindowOptions tenKeyframes() {
    WindowOptions options;
    options.keyframes = options.min_keyframes = 10;
    options.min_interval_s = 0.22;
    options.max_span_s = 0.0;
    return options;
  }
  Calibration calibration_;
  WindowOptions options_ = tenKeyframes();
};

TEST_F(KeyframeWindowTest, TwentyHertzGivesQuarterSecondKeyframesEndingAtTheNewest) {
  const WindowCut cut = fed(3.0).cut();
  ASSERT_NE(cut.window, nullptr) << cut.message;
  EXPECT_EQ(cut.status, InitStatus::kSuccess);
  ASSERT_EQ(cut.window->size(), 10);
  EXPECT_NEAR(cut.window->times().back(), 3.0, 1e-9);
  for (int k = 0; k + 1 < 10; ++k) {
    EXPECT_NEAR(cut.window->times()[k + 1] - cut.window->times()[k], 0.25, 1e-9);
  }
}

TEST_F(KeyframeWindowTest, CutsNoSoonerThanTheWindowIsFull) {
  KeyframeWindow window = fed(2.2);
  const WindowCut early = window.cut();
  EXPECT_EQ(early.window, nullptr);
  EXPECT_EQ(early.status, InitStatus::kTooFewKeyframes);
  expectParts(early.message, "9 keyframes (minimum 10)");
  window.addImu(imu(2.25));
  window.addFrame(frame(2.25));
  EXPECT_NE(window.cut().window, nullptr);
}

// By default every second image at 20 Hz until the window is full; then it thins out.
TEST_F(KeyframeWindowTest, AGrowingWindowKeepsItsBeginningAndThinsOut) {
  options_ = WindowOptions();
  for (const double t_end : {0.4, 1.4, 1.6, 2.3, 3.0, 3.6}) {
    const WindowCut cut = fed(t_end).cut();
    ASSERT_NE(cut.window, nullptr) << cut.message;
    const std::vector<double>& times = cut.window->times();
    EXPECT_NEAR(times.back(), t_end, 1e-9);
    EXPECT_NEAR(times.front(), std::max(0.0, t_end - options_.max_span_s), 1e-9);
    ASSERT_EQ(times.size(), t_end < 1.45 ? std::lround(10 * t_end) + 1 : 15u) << t_end;
    const double even = (times.back() - times.front()) / (times.size() - 1);
    for (std::size_t k = 1; k < times.size(); ++k) {
      EXPECT_GE(times[k] - times[k - 1], options_.min_interval_s);
      EXPECT_LE(std::abs(times[k] - times[k - 1] - even), 0.0501) << t_end << " s, " << k;
    }
  }
}

TEST_F(KeyframeWindowTest, AThinnedWindowHasItsKeyframesOnBothSidesOfAGap) {
  options_ = WindowOptions();
  options_.keyframes = 6;
  KeyframeWindow window = fed(1.0);
  for (int k = 1; k < 160; ++k) window.addImu(imu(1.0 + 0.005 * k));  // dark for 0.8 s
  feed(window, 1.8, 2.5);
  const WindowCut cut = window.cut();
  ASSERT_NE(cut.window, nullptr) << cut.message;
  ASSERT_EQ(cut.window->size(), 6);
  EXPECT_NEAR(cut.window->times().front(), 0.0, 1e-9);
  EXPECT_NEAR(cut.window->times().back(), 2.5, 1e-9);
}

// Slower images than min_interval_s: the window is as long as its keyframes make it.
TEST_F(KeyframeWindowTest, SlowImagesNeedNoThinning) {
  KeyframeWindow window(calibration_, WindowOptions());
  feed(window, 0.0, 10.0, 60);  // 3.3 Hz
  const WindowCut cut = window.cut();
  ASSERT_NE(cut.window, nullptr) << cut.message;
  EXPECT_EQ(cut.window->size(), 15);
  EXPECT_NEAR(cut.window->times().front(), 9.9 - 14 * 0.3, 1e-9);
}

TEST_F(KeyframeWindowTest, CutsWithinASpan) {
  const KeyframeWindow window = fed(2.0);
  WindowOptions every = options_;
  every.keyframes = 50;
  every.min_interval_s = every.max_span_s = 0.0;
  const WindowCut cut = window.cutWithin(every, {0.499, 1.26});
  ASSERT_NE(cut.window, nullptr) << cut.message;
  EXPECT_EQ(cut.window->size(), 16);
  EXPECT_DOUBLE_EQ(cut.window->times().front(), 0.5);
  EXPECT_DOUBLE_EQ(cut.window->times().back(), 1.25);
  // Three frames are not enough, and there are none before the first one.
  EXPECT_EQ(window.cutWithin(every, {0.49, 0.61}).status, InitStatus::kTooFewKeyframes);
  EXPECT_EQ(window.cutWithin(every, {-2.0, -1.0}).window, nullptr);
}

TEST_F(KeyframeWindowTest, AFrameAheadOfTheImuWaitsForIt) {
  options_.min_keyframes = options_.keyframes = 2;
  KeyframeWindow window(calibration_, options_);
  for (int k = 0; k <= 50; ++k) window.addImu(imu(0.005 * k));  // to 0.25 s
  window.addFrame(frame(0.0));
  window.addFrame(frame(0.2502));
  EXPECT_EQ(window.cut().window, nullptr);
  window.addImu(imu(0.255));
  ASSERT_NE(window.cut().window, nullptr);
  EXPECT_NEAR(window.cut().window->times()[1], 0.2502, 1e-12);
}

// A host that estimates td, and begins anew with that of its file: a window has one.
TEST_F(KeyframeWindowTest, TheTimeOffsetMovesFramesToTheImuClockAndMayChange) {
  options_.min_keyframes = options_.keyframes = 2;
  calibration_.td = 0.03;
  KeyframeWindow window(calibration_, options_);
  for (int k = 0; k <= 100; ++k) window.addImu(imu(0.005 * k));
  window.addFrame(frame(0.0));
  window.setTd(0.02);
  window.setTd(kNotComputed);
  window.setTd(1.2);  // beyond what a calibration may have: windows would be refused for it
  EXPECT_EQ(window.calibration().td, 0.02);
  window.addFrame(frame(0.25));
  ASSERT_NE(window.cut().window, nullptr);
  EXPECT_NEAR(window.cut().window->times()[0], 0.02, 1e-12);
  EXPECT_NEAR(window.cut().window->times()[1], 0.27, 1e-12);
  // Backwards by more than a frame interval: the frame would be before the last one.
  window.setTd(-0.3);
  EXPECT_EQ(window.addFrame(frame(0.3)), AddStatus::kOutOfOrder);
}

TEST_F(KeyframeWindowTest, LinesMeetTheirFrameInAnyOrder) {
  options_.min_keyframes = options_.keyframes = 2;
  calibration_.td = 0.03;  // stamps are matched on the camera clock
  KeyframeWindow window(calibration_, options_);
  for (int k = 0; k <= 100; ++k) window.addImu(imu(0.005 * k));
  std::vector<LineObservation> lines(2);
  lines[0].id = 5;
  lines[0].start_bearing = Eigen::Vector3d(0.3, 0.0, 1.0);
  lines[1] = lines[0];  // the same id: dropped when it is cleaned
  EXPECT_EQ(window.addLines(0.25, lines), AddStatus::kWaiting);
  EXPECT_EQ(window.addLines(0.0, lines), AddStatus::kWaiting);
  EXPECT_EQ(window.counts().lines[AddStatus::kWaiting], 2);
  window.addFrame(frame(0.0));
  window.addFrame(frame(0.25));
  EXPECT_EQ(window.counts().lines[AddStatus::kWaiting], 0);
  EXPECT_EQ(window.counts().lines[AddStatus::kAdded], 2);
  EXPECT_EQ(window.counts().observations_duplicate_id, 2);
  ASSERT_NE(window.cut().window, nullptr);
  EXPECT_EQ(window.cut().window->lineTracks().size(), 1u);

  window.addFrame(frame(0.30));
  EXPECT_EQ(window.addLines(0.30, lines), AddStatus::kAdded);
  EXPECT_EQ(window.addLines(0.30, lines), AddStatus::kUnmatched);  // twice
  EXPECT_EQ(window.addLines(0.28, lines), AddStatus::kUnmatched);  // no such frame
  EXPECT_EQ(window.addLines(kNotComputed, lines), AddStatus::kNotFinite);
  window.addLines(0.32, lines);
  window.addFrame(frame(0.35));  // the frame at 0.32 s was skipped
  EXPECT_EQ(window.counts().lines[AddStatus::kAdded], 3);
  EXPECT_EQ(window.counts().lines[AddStatus::kUnmatched], 3);
  EXPECT_EQ(window.counts().lines[AddStatus::kNotFinite], 1);
  // A flood for frames that never come is bounded, and what is dropped is counted.
  for (int i = 0; i < 1000; ++i) window.addLines(10.0 + i, lines);
  EXPECT_EQ(window.counts().lines[AddStatus::kWaiting], 100);
  EXPECT_EQ(window.counts().lines[AddStatus::kUnmatched], 903);
}

TEST_F(KeyframeWindowTest, AJumpBackDropsTheDataOfLiveStreamsAndKeepsTheCounts) {
  KeyframeWindow window(calibration_, options_, StreamOptions::liveData());
  feed(window, 10.0, 13.0);
  window.addLines(14.0, {});
  ASSERT_NE(window.cut().window, nullptr);
  window.addImu(imu(2.0));
  EXPECT_NE(window.cut().window, nullptr);  // it may be a stray stamp
  EXPECT_EQ(window.addImu(imu(2.005)), AddStatus::kRestarted);
  EXPECT_EQ(window.cut().window, nullptr);
  EXPECT_EQ(window.imu().size(), 1u);
  EXPECT_EQ(window.counts().restarts(), 1);
  EXPECT_EQ(window.counts().lines[AddStatus::kWaiting], 0);
  EXPECT_EQ(window.counts().lines[AddStatus::kUnmatched], 1);
  EXPECT_EQ(window.counts().imu.added(), 602);
  feed(window, 2.01, 5.0);
  EXPECT_NE(window.cut().window, nullptr);
}

TEST_F(KeyframeWindowTest, LinesOfTheTimeBeforeARestartDoNotWaitForTheirStampToComeAgain) {
  KeyframeWindow window(calibration_, options_, StreamOptions::liveData());
  feed(window, 10.0, 13.0);
  window.addImu(imu(2.0));
  EXPECT_EQ(window.addImu(imu(2.005)), AddStatus::kRestarted);
  // The tracker lags: lines of the old time, when no frame is there any more.
  EXPECT_EQ(window.addLines(13.0, {LineObservation()}), AddStatus::kWaiting);
  EXPECT_EQ(window.addLines(2.05, {LineObservation()}), AddStatus::kWaiting);
  window.addFrame(frame(2.01));
  EXPECT_EQ(window.counts().lines[AddStatus::kWaiting], 1);
  EXPECT_EQ(window.counts().lines[AddStatus::kUnmatched], 1);
  window.addFrame(frame(2.05));
  EXPECT_EQ(window.counts().lines[AddStatus::kAdded], 1);
}

TEST_F(KeyframeWindowTest, BadMessagesAreDroppedAndCounted) {
  KeyframeWindow window(calibration_, options_);
  EXPECT_EQ(window.addImu(imu(0.0)), AddStatus::kAdded);
  EXPECT_EQ(window.addImu(imu(0.0)), AddStatus::kOutOfOrder);
  EXPECT_EQ(window.addImu(imu(-1.0)), AddStatus::kOutOfOrder);
  ImuSample bad = imu(0.1);
  bad.accel.x() = kNotComputed;
  EXPECT_EQ(window.addImu(bad), AddStatus::kNotFinite);
  EXPECT_EQ(window.addImu(imu(std::numeric_limits<double>::infinity())), AddStatus::kNotFinite);
  bad.accel.x() = 400.0;
  EXPECT_EQ(window.addImu(bad), AddStatus::kGlitch);
  EXPECT_EQ(window.addFrame(frame(0.0)), AddStatus::kAdded);
  EXPECT_EQ(window.addFrame(frame(0.0)), AddStatus::kOutOfOrder);
  EXPECT_EQ(window.addFrame(frame(kNotComputed)), AddStatus::kNotFinite);
  FrameObservation twice = frame(0.05);
  twice.points.push_back(twice.points[0]);
  twice.points.push_back(twice.points[0]);
  twice.points.back().bearing.setZero();
  twice.points.push_back(frame(0.05).points.back());
  twice.points.back().id += 1000;
  twice.points.back().row = kNotComputed;  // of a pixel that is not known
  twice.lines.emplace_back();              // both ends in one place
  EXPECT_EQ(window.addFrame(twice), AddStatus::kAdded);
  EXPECT_EQ(window.counts().imu.added(), 1);
  EXPECT_EQ(window.counts().imu[AddStatus::kOutOfOrder], 2);
  EXPECT_EQ(window.counts().imu[AddStatus::kNotFinite], 2);
  EXPECT_EQ(window.counts().imu[AddStatus::kGlitch], 1);
  EXPECT_EQ(window.counts().frames.added(), 2);
  EXPECT_EQ(window.counts().frames[AddStatus::kOutOfOrder], 1);
  EXPECT_EQ(window.counts().frames[AddStatus::kNotFinite], 1);
  EXPECT_EQ(window.counts().observations_duplicate_id, 1);
  EXPECT_EQ(window.counts().observations_not_finite, 2);
  EXPECT_EQ(window.counts().lines_degenerate, 1);
}

TEST_F(KeyframeWindowTest, NoWindowAcrossAGapInTheFrames) {
  for (const double most_s : {options_.max_frame_gap_s, 1.3}) {
    options_.max_frame_gap_s = most_s;
    KeyframeWindow window = fed(3.0);
    for (int k = 1; k <= 300; ++k) window.addImu(imu(3.0 + 0.005 * k));  // dark for 1.2 s
    for (int k = 0; k < 5; ++k) window.addFrame(frame(4.2 + 0.05 * k));
    const WindowCut cut = window.cut();
    EXPECT_EQ(cut.window != nullptr, most_s > 1.2);
    if (cut.window != nullptr) continue;
    expectParts(cut.message, "gap of 1.2 s between frames");
  }
}

TEST_F(KeyframeWindowTest, NoWindowAcrossAGapInTheImu) {
  KeyframeWindow window = fed(3.0);
  feed(window, 3.1, 4.0);
  const WindowCut cut = window.cut();
  EXPECT_EQ(cut.window, nullptr);
  expectParts(cut.message, "gap (limit 0.05 s)");
  feed(window, 4.005, 5.5);
  ASSERT_NE(window.cut().window, nullptr);
  EXPECT_GE(window.cut().window->times().front(), 3.1 - 1e-9);
}

TEST_F(KeyframeWindowTest, AGapAfterTheNewestFrameDoesNotMatter) {
  // The newest covered frame lies exactly on the last sample before the gap.
  KeyframeWindow window = fed(3.0);
  window.addImu(imu(3.2));
  ASSERT_NE(window.cut().window, nullptr) << window.cut().message;
  EXPECT_NEAR(window.cut().window->times().back(), 3.0, 1e-9);
}

TEST_F(KeyframeWindowTest, AFrameInsideAGapIsNamed) {
  KeyframeWindow window = fed(3.0);
  window.addFrame(frame(3.1));
  window.addImu(imu(3.2));
  expectParts(window.cut().message, "lies in a gap of the IMU data");
}

TEST_F(KeyframeWindowTest, MemoryIsBounded) {
  options_.buffer_s = 4.0;
  KeyframeWindow window = fed(60.0);
  EXPECT_LE(window.imu().size(), 805u);
  EXPECT_GE(window.imu().size(), 795u);
  ASSERT_NE(window.cut().window, nullptr);
  // A camera that falls silent must not let the IMU grow, nor the other way round.
  for (int k = 1; k <= 4000; ++k) window.addImu(imu(60.0 + 0.005 * k));
  EXPECT_LE(window.imu().size(), 805u);
}

TEST_F(KeyframeWindowTest, ResetForgetsEverything) {
  KeyframeWindow window = fed(3.0);
  window.reset();
  EXPECT_EQ(window.counts().imu.added(), 0);
  EXPECT_EQ(window.cut().window, nullptr);
  feed(window, 0.0, 3.0);  // time may start anew
  EXPECT_NE(window.cut().window, nullptr);
}

TEST_F(KeyframeWindowTest, WindowHoldsTheSamplesAroundItAndNoMore) {
  const WindowCut cut = fed(6.0).cut();
  ASSERT_NE(cut.window, nullptr);
  const auto& samples = cut.window->imu();
  EXPECT_LE(samples.front().t, cut.window->times().front());
  // And the margin by which an error of td may move the keyframes.
  constexpr double kMargin = InitWindow::kImuMargin;
  EXPECT_GT(samples.front().t, cut.window->times().front() - kMargin - 0.0051);
  EXPECT_LT(samples.front().t, cut.window->times().front() - kMargin + 0.0051);
  EXPECT_GE(samples.back().t, cut.window->times().back());
  EXPECT_LT(samples.back().t, cut.window->times().back() + kMargin + 0.0051);
}

}  // namespace
}  // namespace slim_init
