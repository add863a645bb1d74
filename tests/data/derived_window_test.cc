// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "data/derived_window.h"

#include <gtest/gtest.h>

#include "support/exact_window.h"

namespace slim_init {
namespace {

class WithObservationsTest : public ::testing::Test {
 protected:
  std::vector<char> keepAll() const {
    return std::vector<char>(window_->pointObservations().size(), kKeepObservation);
  }
  const std::shared_ptr<const InitWindow> window_ = makeExactWindow(ExactWindowOptions()).window;
};

TEST_F(WithObservationsTest, AllKeptIsTheSameWindow) {
  const auto all = withObservations(*window_, keepAll());
  ASSERT_NE(all, nullptr);
  ASSERT_EQ(all->pointTracks().size(), window_->pointTracks().size());
  ASSERT_EQ(all->pointObservations().size(), window_->pointObservations().size());
  for (std::size_t a = 0; a < window_->pointObservations().size(); ++a) {
    EXPECT_EQ(all->pointObservations()[a].bearing, window_->pointObservations()[a].bearing);
    EXPECT_EQ(all->pointObservations()[a].keyframe, window_->pointObservations()[a].keyframe);
  }
}

TEST_F(WithObservationsTest, EverythingButThePointsIsShared) {
  std::vector<char> keep = keepAll();
  keep.front() = kDropObservation;
  const auto fewer = withObservations(*window_, keep);
  ASSERT_NE(fewer, nullptr);
  EXPECT_EQ(&fewer->calibration(), &window_->calibration());
  EXPECT_EQ(fewer->times().data(), window_->times().data());
  EXPECT_EQ(fewer->imu().data(), window_->imu().data());
  EXPECT_EQ(fewer->lineTracks().data(), window_->lineTracks().data());
  EXPECT_EQ(fewer->lineObservations().data(), window_->lineObservations().data());
  EXPECT_EQ(&fewer->linesOfKeyframe(3), &window_->linesOfKeyframe(3));
  EXPECT_NE(fewer->pointObservations().data(), window_->pointObservations().data());
}

TEST_F(WithObservationsTest, SharedPartsOutliveTheFirstWindow) {
  auto first = makeExactWindow(ExactWindowOptions()).window;
  const std::size_t samples = first->imu().size();
  const auto second = withObservations(*first, keepAll());
  first.reset();
  ASSERT_EQ(second->imu().size(), samples);
  EXPECT_EQ(second->imu().back().t, window_->imu().back().t);
  EXPECT_EQ(second->times(), window_->times());
}

TEST_F(WithObservationsTest, NothingKeptLeavesNoTrack) {
  const auto none = withObservations(
      *window_, std::vector<char>(window_->pointObservations().size(), kDropObservation));
  ASSERT_NE(none, nullptr);
  EXPECT_TRUE(none->pointTracks().empty());
  EXPECT_TRUE(none->pointObservations().empty());
  EXPECT_EQ(none->size(), window_->size());
}

TEST_F(WithObservationsTest, ATrackLeftWithOneSightingIsDropped) {
  std::vector<char> keep = keepAll();
  const Track& track = window_->pointTracks()[0];
  for (int a = track.begin + 1; a < track.end; ++a) keep[a] = kDropObservation;
  EXPECT_EQ(withObservations(*window_, keep)->pointTracks().size(),
            window_->pointTracks().size() - 1);
  // With two it stays.
  keep[track.begin + 1] = kKeepObservation;
  const auto two = withObservations(*window_, keep);
  ASSERT_EQ(two->pointTracks().size(), window_->pointTracks().size());
  EXPECT_EQ(two->pointTracks()[0].size(), 2);
}

TEST_F(WithObservationsTest, AMaskOfAnotherSizeIsRefused) {
  EXPECT_EQ(withObservations(*window_, std::vector<char>(3, kKeepObservation)), nullptr);
  std::vector<char> longer = keepAll();
  longer.push_back(kKeepObservation);
  EXPECT_EQ(withObservations(*window_, longer), nullptr);
}

ExactWindow someWindow() {
  ExactWindowOptions options;
  options.readout_s = 0.02;
  options.keyframe_offset_s = 0.0417;
  return makeExactWindow(options);
}

TEST(WithCalibration, MovesTimesAndNothingElse) {
  const ExactWindow exact = someWindow();
  Calibration changed = exact.calibration;
  changed.td += 0.01;
  changed.readout_s *= 1.5;
  const auto window = withCalibration(*exact.window, changed);
  ASSERT_NE(window, nullptr);
  ASSERT_EQ(window->size(), exact.window->size());
  EXPECT_EQ(window->calibration().td, changed.td);
  for (int k = 0; k < window->size(); ++k) {
    EXPECT_NEAR(window->times()[k], exact.window->times()[k] + 0.01, 1e-12);
  }
  ASSERT_EQ(window->pointObservations().size(), exact.window->pointObservations().size());
  for (std::size_t s = 0; s < window->pointObservations().size(); ++s) {
    const WindowPoint &now = window->pointObservations()[s],
                      &before = exact.window->pointObservations()[s];
    EXPECT_EQ(now.bearing, before.bearing);
    EXPECT_EQ(now.keyframe, before.keyframe);
    EXPECT_EQ(now.row, before.row);
  }
  ASSERT_FALSE(window->lineObservations().empty());
  EXPECT_EQ(window->lineObservations()[0].end_row, exact.window->lineObservations()[0].end_row);
  EXPECT_EQ(window->imu().size(), exact.window->imu().size());
}

TEST(WithCalibration, LeavesOutKeyframesThatTheImuDoesNotCover) {
  const ExactWindow exact = someWindow();
  const int n = exact.window->size();
  for (const double shift : {-0.06, 0.06}) {
    Calibration changed = exact.calibration;
    changed.td += shift;
    const auto window = withCalibration(*exact.window, changed);
    ASSERT_NE(window, nullptr);
    EXPECT_EQ(window->size(), n - 1);
    EXPECT_GE(window->times().front(), window->imu().front().t);
    EXPECT_LE(window->times().back(), window->imu().back().t);
    const int dropped = shift < 0.0 ? 1 : 0;
    EXPECT_NEAR(window->times().front(), exact.window->times()[dropped] + shift, 1e-12);
    for (const Track& track : window->pointTracks()) EXPECT_GE(track.size(), 2);
    for (const WindowPoint& s : window->pointObservations()) {
      EXPECT_GE(s.keyframe, 0);
      EXPECT_LT(s.keyframe, n - 1);
    }
    EXPECT_EQ(window->linesOfKeyframe(0).size(), exact.window->linesOfKeyframe(dropped).size());
    for (const WindowLine& line : window->linesOfKeyframe(0)) EXPECT_EQ(line.keyframe, 0);
  }
}

TEST(WithCalibration, RefusesWhatIsNoneAndWhatLeavesNothing) {
  const ExactWindow exact = someWindow();
  Calibration invalid = exact.calibration;
  invalid.R_b_c *= 2.0;
  EXPECT_EQ(withCalibration(*exact.window, invalid), nullptr);
  Calibration far = exact.calibration;
  far.td = 1.0;
  const auto window = withCalibration(*exact.window, far);
  ASSERT_NE(window, nullptr);
  EXPECT_LT(window->size(), exact.window->size());
}

}  // namespace
}  // namespace slim_init
