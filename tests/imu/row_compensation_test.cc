// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/row_compensation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/so3.h"
#include "support/exact_window.h"

namespace slim_init {
namespace {

TEST(RowCompensation, AGlobalShutterNeedsNone) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  EXPECT_EQ(withRowsCompensated(*exact.window, Eigen::Vector3d::Zero()), nullptr);
}

// A camera that turns on the spot, at a rate that changes: every bearing of a far point is seen at
// its own time, and comes back to where the keyframe would have seen it.
TEST(RowCompensation, TurnsBearingsToTheKeyframe) {
  Calibration calibration = eurocCalibration();
  calibration.readout_s = 0.03;
  const Eigen::Vector3d gyro_bias(0.01, -0.02, 0.03);
  // The mean of two neighbouring samples is exact for a rate that is linear in time about one axis.
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
  const auto angle = [](double t) { return 0.8 * t + 1.5 * t * t; };
  std::vector<ImuSample> imu;
  for (int k = 0; k <= 120; ++k) {
    const double t = 0.005 * k;
    ImuSample sample;
    sample.t = t;
    sample.gyro = (0.8 + 3.0 * t) * axis + gyro_bias;
    imu.push_back(sample);
  }
  const auto R_w_c = [&](double t) {
    return Eigen::Matrix3d(expSO3(angle(t) * axis) * calibration.R_b_c);
  };
  std::vector<FrameObservation> frames(3);
  std::vector<Eigen::Vector3d> directions;
  for (int id = 0; id < 9; ++id) {
    directions.push_back(Eigen::Vector3d(0.1 * id - 0.4, 0.3 - 0.07 * id, 1.0).normalized());
  }
  for (int k = 0; k < 3; ++k) {
    frames[k].t = 0.1012 + 0.2 * k;
    for (int id = 0; id < 9; ++id) {
      PointObservation point;
      point.id = id;
      point.row = id / 8.0 - 0.5;
      point.bearing =
          R_w_c(frames[k].t + point.row * calibration.readout_s).transpose() * directions[id];
      frames[k].points.push_back(point);
    }
    LineObservation line;
    line.id = 1;
    line.start_row = -0.4;
    line.end_row = 0.3;
    const double t_start = frames[k].t + line.start_row * calibration.readout_s;
    const double t_end = frames[k].t + line.end_row * calibration.readout_s;
    line.start_bearing = R_w_c(t_start).transpose() * directions[0];
    line.end_bearing = R_w_c(t_end).transpose() * directions[8];
    line.length_px = 100.0;
    frames[k].lines.push_back(line);
  }
  const auto window = madeWindow(calibration, frames, imu);
  const auto compensated = withRowsCompensated(*window, gyro_bias);
  ASSERT_NE(compensated, nullptr);
  ASSERT_EQ(compensated->pointObservations().size(), 27u);
  double largest_before = 0.0;
  for (const Track& track : compensated->pointTracks()) {
    for (int s = track.begin; s < track.end; ++s) {
      const WindowPoint &now = compensated->pointObservations()[s],
                        &raw = window->pointObservations()[s];
      const Eigen::Vector3d expected =
          R_w_c(window->times()[now.keyframe]).transpose() * directions[track.id];
      // Samples between two instants are taken as linear: exact here, to rounding.
      EXPECT_LT((now.bearing - expected).norm(), 1e-9);
      EXPECT_EQ(now.row, raw.row);
      largest_before = std::max(largest_before, (raw.bearing - expected).norm());
    }
  }
  EXPECT_GT(largest_before, 0.01) << "there was something to take off";
  for (const WindowLine& line : compensated->lineObservations()) {
    const Eigen::Matrix3d R = R_w_c(window->times()[line.keyframe]).transpose();
    EXPECT_LT((line.start_bearing - R * directions[0]).norm(), 1e-9);
    EXPECT_LT((line.end_bearing - R * directions[8]).norm(), 1e-9);
    EXPECT_NEAR(std::abs(line.normal.dot(R * directions[0])), 0.0, 1e-9);
  }
  // At another bias it is off by the bias over the row time.
  const auto biased = withRowsCompensated(*window, Eigen::Vector3d::Zero());
  EXPECT_GT(
      (biased->pointObservations()[0].bearing - compensated->pointObservations()[0].bearing).norm(),
      1e-4);
}

}  // namespace
}  // namespace slim_init
