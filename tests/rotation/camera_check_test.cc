// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/camera_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "slim_init/types.h"
#include "support/exact_window.h"
#include "support/robust_bias.h"

namespace slim_init {
namespace {

ExactWindowOptions noisy(unsigned seed, double noise_px) {
  ExactWindowOptions options = drawnFromTheModel(seed, 0.05);
  options.pixel_noise = noise_px;
  return options;
}

// Mean of what windows of several seeds measure [px].
double measuredPx(const ExactWindowOptions& like) {
  constexpr int kSeeds = 5;
  double sum = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    ExactWindowOptions options = like;
    options.seed = seed;
    const ExactWindow exact = makeExactWindow(options);
    sum += robustBiasOf(*exact.window).track_sigma * exact.calibration.focal_px / kSeeds;
  }
  return sum;
}

TEST(TrackNoise, IsFoundWhateverIsAssumed) {
  EXPECT_LT(measuredPx(noisy(1, 0.0)), 0.03);
  for (const double noise_px : {0.3, 0.6, 1.2, 2.0}) {
    EXPECT_NEAR(measuredPx(noisy(1, noise_px)), noise_px, 0.15 * noise_px);
  }
}

// Without translation the direction of travel is fitted to noise, and takes some of it.
TEST(TrackNoise, IsFoundWithoutTranslation) {
  for (const Motion motion : {Motion::kHover, Motion::kPureRotation}) {
    ExactWindowOptions options = noisy(1, 0.6);
    options.motion = motion;
    EXPECT_NEAR(measuredPx(options), 0.6, 0.2 * 0.6);
  }
}

TEST(TrackNoise, IsThatOfTheTracksThatAreNoGrossErrors) {
  ExactWindow exact = makeExactWindow(noisy(1, 0.6));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (FrameObservation& frame : exact.keyframes) {
    for (PointObservation& point : frame.points) {
      if (point.id % 4 != 0) continue;
      const double x = uniform(random), y = uniform(random);
      point.bearing = (point.bearing + 0.05 * Eigen::Vector3d(x, y, 0.0)).normalized();
    }
  }
  const auto window = windowOf(exact);
  EXPECT_NEAR(robustBiasOf(*window).track_sigma * exact.calibration.focal_px, 0.6, 0.2 * 0.6);
}

TEST(TrackNoise, IsNotMeasuredWithFewPoints) {
  ExactWindowOptions options = noisy(1, 0.6);
  options.points = 4;
  EXPECT_TRUE(std::isnan(robustBiasOf(*makeExactWindow(options).window).track_sigma));
}

// A window of a camera with this readout that is taken for another.
ReadoutCheck readoutOf(unsigned seed, double true_s, double assumed_s) {
  ExactWindowOptions options = noisy(seed, 0.6);
  options.keyframe_offset_s = 0.0617;
  options.readout_s = true_s;
  ExactWindow exact = makeExactWindow(options);
  exact.calibration.readout_s = assumed_s;
  return robustBiasOf(*windowOf(exact)).readout;
}

// Far within the standard deviation of one window for a global shutter; one step from nothing is
// good to a tenth of a rolling one.
TEST(ReadoutCheck, FindsWhatNobodyDeclared) {
  for (const double true_s : {0.0, 0.015, 0.03}) {
    double normalized2 = 0.0;
    constexpr int kSeeds = 20;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      const ReadoutCheck check = readoutOf(seed, true_s, 0.0);
      ASSERT_TRUE(check.valid);
      const double error = std::abs(check.error_s - true_s);
      EXPECT_LT(error, 4.0 * check.sigma_s + 0.15 * true_s);
      normalized2 += error * error / (check.sigma_s * check.sigma_s) / kSeeds;
    }
    if (true_s == 0.0) {
      EXPECT_LT(normalized2, 1.5);
      EXPECT_GT(normalized2, 0.2);
    }
  }
}

TEST(ReadoutCheck, NeedsRowsAndRotation) {
  ExactWindow exact = makeExactWindow(noisy(1, 0.6));
  for (FrameObservation& frame : exact.keyframes) setRows(0, &frame);
  EXPECT_FALSE(robustBiasOf(*windowOf(exact)).readout.valid);
  ExactWindowOptions options = noisy(1, 0.6);
  options.motion = Motion::kHover;
  EXPECT_FALSE(robustBiasOf(*makeExactWindow(options).window).readout.valid);
}

}  // namespace
}  // namespace slim_init
