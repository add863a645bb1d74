// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What surrounds the minimisation: noise from the data, rejection, the choice between starts,
// lines, and input that is no use.
#include "estimation/refine_window.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "estimation/posterior.h"
#include "geometry/so3.h"
#include "support/data_sheet_options.h"
#include "support/exact_window.h"
#include "support/true_state.h"
#include "support/unlimited_budget.h"

namespace slim_init {
namespace {

ExactWindowOptions noisy(unsigned seed, double pixel_noise = 0.6) {
  ExactWindowOptions options = drawnFromTheModel(seed, 0.0);
  options.pixel_noise = pixel_noise;
  return options;
}

RefinedWindow refine(const InitWindow& window, const WindowState& start,
                     const RefinementOptions& options) {
  const InertialOptions inertial = dataSheetNoise();
  const std::vector<Preintegration> pre =
      preintegrateInflated(window, start.gyro_bias, Eigen::Vector3d::Zero(), inertial);
  WorkBudget budget = unlimitedBudget();
  return refineWindow({window, pre, options, inertial, budget}, window.lineTracks(), start);
}

double spread(const WindowState& state) {
  return (state.p_b0.colwise() - state.p_b0.rowwise().mean()).norm();
}

double scaleError(const RefinedWindow& refined, const WindowState& truth) {
  return std::abs(spread(refined.state) / spread(truth) - 1.0);
}

TEST(RefineWindow, NoiseIsThatOfTheData) {
  // The calibration says 0.6 px throughout.
  for (const double sigma_px : {0.3, 0.6, 1.5}) {
    const ExactWindow exact = makeExactWindow(noisy(3, sigma_px));
    const RefinedWindow refined = refine(*exact.window, trueState(exact), RefinementOptions());
    ASSERT_TRUE(refined.valid);
    EXPECT_NEAR(refined.sigma_px, sigma_px, 0.1 * sigma_px);
    EXPECT_NEAR(refined.sigma_line_px, sigma_px, 0.2 * sigma_px);
  }
}

TEST(RefineWindow, NoiseHasAFloor) {
  const ExactWindow exact = makeExactWindow(noisy(3, 0.05));
  RefinementOptions options;
  options.min_sigma_px = 0.2;
  RefinedWindow refined = refine(*exact.window, trueState(exact), options);
  ASSERT_TRUE(refined.valid);
  EXPECT_NEAR(refined.sigma_px, 0.2, 1e-12);
  EXPECT_NEAR(refined.sigma_line_px, 0.2, 1e-12);
  options.min_sigma_px = 0.01;
  refined = refine(*exact.window, trueState(exact), options);
  EXPECT_NEAR(refined.sigma_px, 0.05, 0.01);
}

TEST(RefineWindow, TooFewResidualsKeepTheNoiseOfTheCalibration) {
  ExactWindowOptions window_options = noisy(3, 1.5);
  window_options.lines = 1;
  const ExactWindow exact = makeExactWindow(window_options);
  ASSERT_EQ(exact.window->lineTracks().size(), 1u);
  const RefinedWindow refined = refine(*exact.window, trueState(exact), RefinementOptions());
  ASSERT_TRUE(refined.valid);
  EXPECT_NEAR(refined.sigma_line_px, exact.calibration.lineSigmaPx(), 1e-12);
  EXPECT_NEAR(refined.sigma_px, 1.5, 0.15);
}

TEST(RefineWindow, OutliersAreTakenOutAndOnlyThose) {
  const ExactWindow exact = makeExactWindow(noisy(5));
  const WindowState truth = trueState(exact);
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<FrameObservation> frames = exact.keyframes;
  int observations = 0, wrong = 0;
  for (FrameObservation& frame : frames) {
    for (PointObservation& point : frame.points) {
      ++observations;
      if (uniform(rng) >= 0.05) continue;
      ++wrong;
      const double angle = 2.0 * M_PI * uniform(rng);
      const double length = 20.0 / exact.calibration.focal_px;
      point.bearing =
          (point.bearing + length * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0))
              .normalized();
    }
  }
  ASSERT_GT(wrong, 20);
  const auto window = windowOf(exact, frames);
  const RefinedWindow refined = refine(*window, truth, {});
  ASSERT_TRUE(refined.valid);
  // A Rayleigh variable is beyond 3.5 sigma once in 450; short tracks, which bend to their outlier,
  // lose good observations with it.
  const double share = static_cast<double>(wrong) / observations;
  EXPECT_LE(refined.inlier_fraction, 1.0 - 0.95 * share);
  EXPECT_GE(refined.inlier_fraction, 1.0 - share - 0.04);
  EXPECT_NEAR(refined.sigma_px, 0.6, 0.1);
  EXPECT_LT(scaleError(refined, truth), 0.02);

  RefinementOptions keep_all;
  keep_all.reject_sigmas = 1e6;
  const RefinedWindow with_all = refine(*window, truth, keep_all);
  ASSERT_TRUE(with_all.valid);
  EXPECT_EQ(with_all.inlier_fraction, 1.0);
  EXPECT_NEAR(with_all.cost, refined.cost, 1e-9 * refined.cost) << "before any rejection";
}

TEST(RefineWindow, ResidualsBeyondTheBoundAreTakenOut) {
  const ExactWindow exact = makeExactWindow(noisy(3, 0.05));
  RefinementOptions options;
  options.min_sigma_px = 0.01;
  options.reject_sigmas = 2.0;
  const double kept = refine(*exact.window, trueState(exact), options).inlier_fraction;
  EXPECT_LT(kept, 0.95);
  EXPECT_GT(kept, 0.75) << "beyond two sigma is 13.5 %";
}

TEST(RefineWindow, AWrongLineIsTakenOut) {
  const ExactWindow exact = makeExactWindow(noisy(6));
  std::vector<FrameObservation> frames = exact.keyframes;
  FeatureId id = -1;
  for (const Track& track : exact.window->lineTracks()) {
    if (track.size() >= 8) id = track.id;
  }
  ASSERT_GE(id, 0);
  // In every other view another segment, 30 px beside it.
  int views = 0;
  for (FrameObservation& frame : frames) {
    for (LineObservation& line : frame.lines) {
      if (line.id != id || ++views % 2 == 0) continue;
      const Eigen::Vector3d aside = line.start_bearing.cross(line.end_bearing).normalized();
      line.start_bearing += 30.0 / exact.calibration.focal_px * aside;
      line.end_bearing += 30.0 / exact.calibration.focal_px * aside;
    }
  }
  const auto window = windowOf(exact, frames);
  const RefinedWindow clean = refine(*exact.window, trueState(exact), {});
  const RefinedWindow refined = refine(*window, trueState(exact), {});
  ASSERT_TRUE(clean.valid && refined.valid);
  EXPECT_GT(refined.cost, clean.cost + 10.0);
  EXPECT_NEAR(refined.sigma_line_px, clean.sigma_line_px, 0.15 * clean.sigma_line_px);
  EXPECT_LT((refined.state.p_b0 - clean.state.p_b0).norm(), 0.02 * spread(clean.state));
}

TEST(RefineWindow, AStartThatIsNotFiniteIsRefused) {
  const ExactWindow exact = makeExactWindow(noisy(1));
  WindowState broken = trueState(exact);
  broken.p_b0(1, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(refine(*exact.window, broken, RefinementOptions()).valid);
}

TEST(RefineWindow, ACovarianceThatIsNoneIsRefused) {
  const ExactWindow exact = makeExactWindow(noisy(1));
  const WindowState truth = trueState(exact);
  const RefinementOptions options;
  std::vector<Preintegration> pre =
      preintegrateInflated(*exact.window, truth.gyro_bias, truth.accel_bias, dataSheetNoise());
  const InertialOptions inertial = dataSheetNoise();
  WorkBudget budget = unlimitedBudget();
  const RefinementInput input = {*exact.window, pre, options, inertial, budget};
  EXPECT_TRUE(refineWindow(input, {}, truth).valid);
  pre[4].covariance.setZero();
  EXPECT_FALSE(refineWindow(input, {}, truth).valid);
}

TEST(RefineWindow, PreintegratesAnewWhereTheGyroscopeBiasMovedFar) {
  const ExactWindow exact = makeExactWindow(noisy(9));
  const WindowState truth = trueState(exact);
  WindowState off = truth;
  off.gyro_bias += Eigen::Vector3d(0.03, -0.04, 0.02);
  RefinementOptions options;
  options.max_iterations = 30;
  options.tolerance = 1e-6;
  const RefinedWindow at_truth = refine(*exact.window, truth, options);
  const RefinedWindow refined = refine(*exact.window, off, options);
  ASSERT_TRUE(at_truth.valid && refined.valid);
  // First order in a bias that is 0.05 rad/s off would leave 1e-4 rad/s.
  EXPECT_LT((refined.state.gyro_bias - at_truth.state.gyro_bias).norm(), 2e-5);
  EXPECT_LT(scaleError(refined, truth), 0.02);
}

// A gyroscope that is worse than assumed turns the images no more, also where they are better than
// the 0.6 px assumed; what no sensor has is left to the gates.
TEST(RefineWindow, AGyroscopeIsTrustedAsItsWindowShows) {
  const struct {
    double times, sigma_px, max_error;
    bool passes;
  } rows[] = {{1.0, 0.2, 0.006, true}, {3.5, 0.2, 0.015, true}, {20.0, 0.2, 0.04, false}};
  for (const auto& row : rows) {
    double scale_error2 = 0.0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      ExactWindow exact = makeExactWindow(noisy(seed, row.sigma_px));
      const double sigma = exact.calibration.imu_noise.gyro_density * std::sqrt(200.0);
      Gaussian random(seed);
      for (ImuSample& sample : exact.imu) sample.gyro += row.times * sigma * random.vector();
      const WindowState truth = trueState(exact);
      const RefinedWindow refined = refine(*windowOf(exact), truth, RefinementOptions());
      ASSERT_TRUE(refined.valid);
      EXPECT_EQ(refined.inertial_chi2 < GateOptions().max_inertial_chi2, row.passes)
          << row.times << " seed " << seed << " " << refined.inertial_chi2;
      scale_error2 += 0.1 * std::pow(scaleError(refined, truth), 2);
    }
    EXPECT_LT(std::sqrt(scale_error2), row.max_error) << row.times;
  }
}

TEST(RefineWindow, TheAccelerometerBiasIsFoundOrHeld) {
  ExactWindowOptions window_options = noisy(4);
  window_options.accel_bias = Eigen::Vector3d(0.12, -0.1, 0.15);
  const ExactWindow exact = makeExactWindow(window_options);
  WindowState start = trueState(exact);
  start.accel_bias.setZero();
  RefinementOptions options;
  const RefinedWindow found = refine(*exact.window, start, options);
  ASSERT_TRUE(found.valid);
  const Posterior posterior = posteriorOf(found.state, withoutRig(found.information));
  ASSERT_TRUE(posterior.valid);
  const int at = 9 * found.state.size() + 3;
  for (int i = 0; i < 3; ++i) {
    const double sigma = std::sqrt(posterior.covariance(at + i, at + i));
    EXPECT_LT(std::abs(found.state.accel_bias[i] - window_options.accel_bias[i]), 4.0 * sigma) << i;
    EXPECT_LT(sigma, 0.9 * InertialOptions().accel_bias_prior) << "the data say nothing";
  }
  options.estimate_accel_bias = false;
  const RefinedWindow held = refine(*exact.window, start, options);
  ASSERT_TRUE(held.valid);
  EXPECT_LT(held.state.accel_bias.norm(), 1e-6);
  EXPECT_GT(held.inertial_chi2, found.inertial_chi2);
}

TEST(RefineWindow, LinesAddWhatPointsLack) {
  double with_sigma = 0.0, without_sigma = 0.0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    ExactWindowOptions window_options = noisy(seed);
    window_options.points = 10;
    const ExactWindow exact = makeExactWindow(window_options);
    const WindowState truth = trueState(exact);
    RefinementOptions options;
    const RefinedWindow with = refine(*exact.window, truth, options);
    options.use_lines = false;
    const RefinedWindow without = refine(*exact.window, truth, options);
    ASSERT_TRUE(with.valid && without.valid);
    EXPECT_LT(scaleError(with, truth), 0.1);
    with_sigma += posteriorOf(with.state, withoutRig(with.information)).scale_sigma;
    without_sigma += posteriorOf(without.state, withoutRig(without.information)).scale_sigma;
  }
  EXPECT_LT(with_sigma, 0.9 * without_sigma);
}

}  // namespace
}  // namespace slim_init
