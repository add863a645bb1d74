// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "data/derived_window.h"
#include "support/exact_window.h"

namespace slim_init {
namespace {

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
