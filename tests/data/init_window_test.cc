// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/init_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>

#include "support/exact_window.h"
#include "support/text_parts.h"

namespace slim_init {
namespace {

class InitWindowTest : public ::testing::Test {
 protected:
  const ExactWindow exact_ = makeExactWindow(ExactWindowOptions());
};

TEST_F(InitWindowTest, TracksAreSortedAndComplete) {
  const InitWindow& window = *exact_.window;
  EXPECT_EQ(window.size(), 10);
  int observations = 0;
  for (const Track& track : window.pointTracks()) {
    EXPECT_GE(track.size(), 2);
    observations += track.size();
    for (int s = track.begin; s + 1 < track.end; ++s) {
      EXPECT_LT(window.pointObservations()[s].keyframe, window.pointObservations()[s + 1].keyframe);
    }
  }
  EXPECT_EQ(observations, static_cast<int>(window.pointObservations().size()));
  for (std::size_t t = 0; t + 1 < window.pointTracks().size(); ++t) {
    EXPECT_LT(window.pointTracks()[t].id, window.pointTracks()[t + 1].id);
  }
}

// All that a method sees is the window: the order cannot change its estimate either.
TEST_F(InitWindowTest, OrderOfObservationsDoesNotMatter) {
  std::vector<FrameObservation> shuffled = exact_.keyframes;
  std::mt19937_64 random(3);
  for (FrameObservation& frame : shuffled) {
    std::shuffle(frame.points.begin(), frame.points.end(), random);
    std::shuffle(frame.lines.begin(), frame.lines.end(), random);
  }
  const auto window = windowOf(exact_, shuffled);
  const auto expectSame = [](const auto& now, const auto& before, const auto& fields) {
    ASSERT_EQ(now.size(), before.size());
    for (std::size_t i = 0; i < now.size(); ++i) EXPECT_TRUE(fields(now[i]) == fields(before[i]));
  };
  const auto trackFields = [](const Track& t) { return std::tie(t.id, t.begin, t.end); };
  const auto pointFields = [](const WindowPoint& p) {
    return std::tie(p.bearing, p.keyframe, p.row);
  };
  const auto lineFields = [](const WindowLine& l) {
    return std::tie(l.keyframe, l.start_bearing, l.end_bearing, l.normal, l.length_px,
                    l.detection_confidence, l.match_quality, l.start_row, l.end_row);
  };
  const InitWindow& before = *exact_.window;
  expectSame(window->pointTracks(), before.pointTracks(), trackFields);
  expectSame(window->lineTracks(), before.lineTracks(), trackFields);
  expectSame(window->pointObservations(), before.pointObservations(), pointFields);
  expectSame(window->lineObservations(), before.lineObservations(), lineFields);
  for (int k = 0; k < window->size(); ++k) {
    expectSame(window->linesOfKeyframe(k), before.linesOfKeyframe(k), lineFields);
  }
}

TEST_F(InitWindowTest, LineNormalIsAtRightAnglesToItsEnds) {
  ASSERT_FALSE(exact_.window->lineObservations().empty());
  for (const WindowLine& line : exact_.window->lineObservations()) {
    EXPECT_NEAR(line.normal.norm(), 1.0, 1e-14);
    EXPECT_NEAR(line.normal.dot(line.start_bearing), 0.0, 1e-14);
    EXPECT_NEAR(line.normal.dot(line.end_bearing), 0.0, 1e-14);
  }
}

TEST_F(InitWindowTest, UnusableObservationsAreDropped) {
  std::vector<FrameObservation> frames = exact_.keyframes;
  const std::size_t points = frames[0].points.size();
  PointObservation bad = frames[0].points[0];
  bad.id = 5000;
  bad.bearing.y() = kNotComputed;
  frames[0].points.push_back(bad);
  bad.id = 5001;
  bad.bearing.setZero();
  frames[0].points.push_back(bad);
  frames[0].points.push_back(frames[0].points[0]);  // same id again
  LineObservation line = frames[0].lines[0];
  line.id = 6000;
  line.end_bearing = line.start_bearing;
  frames[0].lines.push_back(line);
  const auto window = InitWindow::create(exact_.calibration, frames, exact_.imu);
  ASSERT_NE(window, nullptr);
  EXPECT_EQ(window->pointObservations().size(), exact_.window->pointObservations().size());
  EXPECT_GT(points, 0u);
}

TEST_F(InitWindowTest, BearingsAreNormalised) {
  std::vector<FrameObservation> frames = exact_.keyframes;
  for (PointObservation& point : frames[2].points) point.bearing /= point.bearing.z();  // (x, y, 1)
  const auto window = InitWindow::create(exact_.calibration, frames, exact_.imu);
  ASSERT_NE(window, nullptr);
  for (const WindowPoint& s : window->pointObservations())
    EXPECT_NEAR(s.bearing.norm(), 1.0, 1e-14);
}

TEST_F(InitWindowTest, ViolatedInvariantsAreNamed) {
  const auto expectRefused = [this](const char* words, void (*spoil)(ExactWindow*)) {
    ExactWindow bad = exact_;
    spoil(&bad);
    std::string error;
    EXPECT_EQ(InitWindow::create(bad.calibration, bad.keyframes, bad.imu, &error), nullptr);
    expectParts(error, words);
  };
  expectRefused("1 keyframes (minimum 2)", [](ExactWindow* bad) { bad->keyframes.resize(1); });
  expectRefused("keyframe 4 is -0.25 s",
                [](ExactWindow* bad) { std::swap(bad->keyframes[3], bad->keyframes[4]); });
  expectRefused("keyframe 2", [](ExactWindow* bad) { bad->keyframes[2].t = kNotComputed; });
  expectRefused("do not cover", [](ExactWindow* bad) { bad->imu.resize(bad->imu.size() - 20); });
  expectRefused("0 samples", [](ExactWindow* bad) { bad->imu.clear(); });
  expectRefused("sample 7 is not finite",
                [](ExactWindow* bad) { bad->imu[7].gyro.z() = kNotComputed; });
  expectRefused("sample 9 is 0 s", [](ExactWindow* bad) { bad->imu[9].t = bad->imu[8].t; });
  expectRefused("sigma_px is -1", [](ExactWindow* bad) { bad->calibration.sigma_px = -1.0; });
}

}  // namespace
}  // namespace slim_init
