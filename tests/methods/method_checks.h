// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is asked of every method, those that need Ceres included.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "slim_init/window_solver.h"
#include "support/exact_window.h"

namespace slim_init {

/// Everything is recovered, to `relative` of its size.
inline void expectRecovered(const ExactWindow& exact, const InitResult& result, double relative) {
  ASSERT_TRUE(result.success()) << result.message;
  ASSERT_EQ(result.states.size(), exact.truth.size());
  double path = 0.0, speed = 0.0;
  for (const NavState& state : exact.truth) {
    speed = std::max(speed, state.v_w_b.norm());
    path = std::max(path, (state.p_w_b - exact.truth[0].p_w_b).norm());
  }
  const Eigen::Vector3d& gyro_bias = exact.truth[0].gyro_bias;
  EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), relative);
  EXPECT_LT(gravityErrorRad(result.gravity_b0, exact.truth[0]), relative);
  EXPECT_LT(velocityRmse(result.states, exact.truth), relative * speed);
  EXPECT_LT(positionRmse(result.states, exact.truth), relative * path);
  EXPECT_LT((result.gyro_bias - gyro_bias).norm(), relative * gyro_bias.norm());
  EXPECT_LT(result.states[0].p_w_b.norm(), 1e-12);
}

/// Accelerations of 1.4 m/s^2 over 2.25 s, 100 points at 0.6 px, EuRoC's IMU, no accelerometer
/// bias: errors of `windows` answers, ascending.
struct NoisyErrors {
  NoisyErrors(const WindowSolver& solver, unsigned windows) {
    for (unsigned seed = 1; seed <= windows; ++seed) {
      const ExactWindow exact = noisyWindow(Motion::kExcited, seed);
      const InitResult result = solver.solve(*exact.window);
      EXPECT_TRUE(result.hasEstimate()) << "seed " << seed << ": " << result.message;
      if (!result.hasEstimate()) continue;
      scale.push_back(std::abs(scaleError(result.states, exact.truth)));
      gravity_deg.push_back(gravityErrorRad(result.gravity_b0, exact.truth[0]) * 180.0 / M_PI);
    }
    std::sort(scale.begin(), scale.end());
    std::sort(gravity_deg.begin(), gravity_deg.end());
  }
  std::vector<double> scale, gravity_deg;
};

/// All points, and all lines, in one place of every image.
inline std::shared_ptr<const InitWindow> windowOfParallelBearings() {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  std::vector<FrameObservation> frames = exact.keyframes;
  for (FrameObservation& frame : frames) {
    for (PointObservation& point : frame.points) point.bearing = Eigen::Vector3d::UnitZ();
    for (LineObservation& line : frame.lines) {
      line.start_bearing = Eigen::Vector3d(0, 0, 1);
      line.end_bearing = Eigen::Vector3d(0, 0.1, 1).normalized();
    }
  }
  return windowOf(exact, frames);
}

}  // namespace slim_init
