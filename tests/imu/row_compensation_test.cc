// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/row_compensation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/exact_window.h"

namespace slim_init {
namespace {

using namespace testing_support;  // NOLINT: the vocabulary of these tests

TEST(RowCompensation, AGlobalShutterNeedsNone) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  EXPECT_EQ(withRowsCompensated(*exact.window, Eigen::Vector3d::Zero()), nullptr);
}

// A camera that turns on the spot sees every point at its own time where a global shutter would
// have seen it, once the turn in between is taken off.
TEST(RowCompensation, TurnsABearingToTheKeyframe) {
  ExactWindowOptions options;
  options.motion = Motion::kPureRotation;
  options.keyframe_offset_s = 0.0417;
  const ExactWindow global = makeExactWindow(options);
  options.readout_s = 0.03;
  ExactWindow rolling = makeExactWindow(options);
  const auto compensated = withRowsCompensated(*rolling.window, options.gyro_bias);
  ASSERT_NE(compensated, nullptr);
  const double lever = rolling.calibration.t_b_c.norm();
  // The lever arm alone moves the camera, over 15 ms at 0.45 rad/s; points are at least 2 m away.
  const double bound = lever * 0.45 * 0.015 / 1.5;
  double largest_before = 0.0;
  int compared = 0;
  for (const Track& track : compensated->pointTracks()) {
    for (const Track& other : global.window->pointTracks()) {
      if (other.id != track.id) continue;
      for (int s = track.begin; s < track.end; ++s) {
        const PointSighting& now = compensated->pointSightings()[s];
        const PointSighting& raw = rolling.window->pointSightings()[s];
        EXPECT_EQ(now.dt, raw.dt);
        for (int g = other.begin; g < other.end; ++g) {
          const PointSighting& expected = global.window->pointSightings()[g];
          if (expected.keyframe != now.keyframe) continue;
          EXPECT_LT((now.bearing - expected.bearing).norm(), bound);
          largest_before = std::max(largest_before, (raw.bearing - expected.bearing).norm());
          ++compared;
        }
      }
    }
  }
  EXPECT_GT(compared, 200);
  EXPECT_GT(largest_before, 5.0 * bound) << "there was something to take off";
}

}  // namespace
}  // namespace slim_init
