// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Starting points of the refinement.
#include "scale/starting_states.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>

#include "pipeline/solver_support.h"
#include "support/exact_window.h"
#include "support/true_state.h"

namespace slim_init {
namespace {

struct Prepared {
  ExactWindow exact;
  std::shared_ptr<const InitWindow> window;
  std::vector<Preintegration> pre;
  std::vector<Eigen::Matrix3d> R_b0_bk, R_c0_ck;
  TranslationEstimate translation;
};

Prepared makePrepared(const ExactWindowOptions& options, int sliding_points = 0) {
  Prepared s;
  s.exact = withSlidingPoints(makeExactWindow(options), sliding_points);
  s.window = s.exact.window;
  s.pre = preintegrateWindow(*s.window, options.gyro_bias, Eigen::Vector3d::Zero(),
                             PreintegrationParts::kMean);
  s.R_b0_bk = chainRotations(s.pre);
  s.R_c0_ck = cameraRotations(s.R_b0_bk, s.exact.calibration.R_b_c);
  s.translation = estimateTranslations(*s.window, s.R_c0_ck);
  return s;
}

double spread(const Eigen::Matrix3Xd& p) { return (p.colwise() - p.rowwise().mean()).norm(); }

double trueSpread(const ExactWindow& exact) { return spread(trueState(exact).p_b0); }

TEST(StartingStates, WithoutNoiseTheyAreTheTruth) {
  ExactWindowOptions options;
  const Prepared s = makePrepared(options);
  ASSERT_TRUE(s.translation.valid);
  for (const auto& start : {startingState(*s.window, s.pre, s.translation, InertialOptions()),
                            inertialStartingState(*s.window, s.pre, InertialOptions())}) {
    ASSERT_TRUE(start.has_value());
    // The search for the scale ends at a relative 1e-5.
    EXPECT_NEAR(spread(start->p_b0), trueSpread(s.exact), 1e-4 * trueSpread(s.exact));
    EXPECT_LT(gravityErrorRad(start->gravity_b0, s.exact.truth[0]), 1e-4);
    EXPECT_LT(start->accel_bias.norm(), 1e-3);
    EXPECT_EQ(start->gyro_bias, options.gyro_bias);
  }
}

// The noise of the tracks multiplies the centres and makes them smaller, never larger.
TEST(InertialStartingState, NoiseAndSlidingTracksLeaveTheScale) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    ExactWindowOptions options;
    options.pixel_noise = 0.6;
    options.seed = seed;
    options.points = 40;
    const Prepared s = makePrepared(options, 10);
    const std::optional<WindowState> start =
        inertialStartingState(*s.window, s.pre, InertialOptions());
    ASSERT_TRUE(start.has_value()) << seed;
    EXPECT_GT(spread(start->p_b0), 0.8 * trueSpread(s.exact)) << seed;
    EXPECT_LT(spread(start->p_b0), 1.1 * trueSpread(s.exact)) << seed;
  }
}

// Each half of the window has its own points: no shape links them, the IMU does.
TEST(InertialStartingState, NeedsNoTrackThatLinksTheWindow) {
  Prepared s = makePrepared(ExactWindowOptions());
  std::vector<FrameObservation> frames = s.exact.keyframes;
  for (std::size_t k = frames.size() / 2; k < frames.size(); ++k) {
    for (PointObservation& point : frames[k].points) point.id += 1000000;
  }
  s.window = windowOf(s.exact, frames);
  const std::optional<WindowState> start =
      inertialStartingState(*s.window, s.pre, InertialOptions());
  ASSERT_TRUE(start.has_value());
  EXPECT_NEAR(spread(start->p_b0), trueSpread(s.exact), 1e-3 * trueSpread(s.exact));
  s.translation = estimateTranslations(*s.window, s.R_c0_ck);
  const std::optional<WindowState> of_shape =
      startingState(*s.window, s.pre, s.translation, InertialOptions());
  if (of_shape) {
    EXPECT_GT(std::abs(spread(of_shape->p_b0) / trueSpread(s.exact) - 1.0), 0.01);
  }
}

TEST(InertialStartingState, NoneFromViewsOfNothing) {
  Prepared s = makePrepared(ExactWindowOptions());
  std::vector<FrameObservation> frames = s.exact.keyframes;
  for (FrameObservation& frame : frames) frame.points.clear();
  s.window = windowOf(s.exact, frames);
  EXPECT_FALSE(inertialStartingState(*s.window, s.pre, InertialOptions()).has_value());
}

}  // namespace
}  // namespace slim_init
