// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/robust_bias.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "rotation/multi_gap_bias.h"
#include "support/exact_window.h"
#include "support/robust_bias.h"

namespace slim_init {
namespace {

using Eigen::Vector3d;

// Medians over this many windows.
constexpr unsigned kWindows = 20;

ExactWindowOptions noisy(unsigned seed) {
  ExactWindowOptions options = seeded(seed, 0.6);
  options.imu_noise = true;
  return options;
}

// By all tracks, over all gaps, with weights that fall from round to round.
Vector3d unprunedBias(const InitWindow& window) {
  const InertialOptions inertial;
  MultiGapProblem problem(window, nullptr, inertial, RigPrior());
  const int gap = kLongestGap;
  Baselines drawn(problem.pairs().size(), Eigen::Vector3d::Zero());
  findBaselines(problem.pairs(), problem.rotationsAt(RotationUnknowns::Zero(), gap), gap, {10.0},
                &drawn);
  return problem
      .minimize(RotationUnknowns::Zero(), gap, {10.0, 5.0, 3.0, 3.0}, {}, std::move(drawn))
      .x.head<3>();
}

struct Corrupted {
  std::shared_ptr<const InitWindow> window;
  std::set<std::pair<FeatureId, int>> moved;  // id and keyframe of the observations that were moved
};

// Moves every observation with probability `rate`, by 20 px per axis (standard deviation).
Corrupted withRandomOutliers(const ExactWindow& exact, double rate, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> gaussian(0.0, 20.0);
  Corrupted out;
  std::vector<FrameObservation> frames = exact.keyframes;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (PointObservation& point : frames[k].points) {
      if (uniform(random) >= rate) continue;
      const double dx = gaussian(random), dy = gaussian(random);
      shift(dx, dy, exact.calibration.focal_px, &point);
      out.moved.emplace(point.id, static_cast<int>(k));
    }
  }
  out.window = windowOf(exact, frames);
  return out;
}

// Between some keyframes a patch of the image jumps by one period of its texture, for good.
Corrupted withCoherentOutliers(const ExactWindow& exact, double share, unsigned seed) {
  std::mt19937_64 random(seed);
  Corrupted out;
  std::vector<FrameObservation> frames = exact.keyframes;
  std::map<FeatureId, double> offset;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    std::vector<PointObservation>& points = frames[k].points;
    if (k > 0 && !points.empty()) {
      const Vector3d centre = points[random() % points.size()].bearing;
      std::vector<std::pair<double, FeatureId>> near;
      for (const PointObservation& point : points) {
        near.emplace_back((point.bearing - centre).norm(), point.id);
      }
      std::sort(near.begin(), near.end());
      const double jump_px = random() % 2 == 0 ? 24.0 : -24.0;
      for (std::size_t q = 0; q < share * static_cast<double>(near.size()); ++q) {
        offset[near[q].second] += jump_px;
      }
    }
    for (PointObservation& point : points) {
      const auto found = offset.find(point.id);
      if (found == offset.end()) continue;
      shift(found->second, 0.0, exact.calibration.focal_px, &point);
    }
  }
  out.window = windowOf(exact, frames);
  return out;
}

TEST(RobustBias, NoiseFreeRecovery) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ExactWindowOptions options = seeded(seed);
    const ExactWindow exact = makeExactWindow(options);
    InertialOptions inertial;
    inertial.gyro_bias_prior = 100.0;  // its pull towards zero is all that is left
    const RobustBias estimate = robustBiasOf(*exact.window, inertial);
    ASSERT_TRUE(estimate.valid());
    EXPECT_LT(relativeError(estimate.gyro_bias, options.gyro_bias), 1e-8) << "seed " << seed;
    EXPECT_EQ(estimate.inlierFraction(), 1.0);
    EXPECT_EQ(estimate.pruning.keep, std::vector<char>(estimate.pruning.keep.size(), 1));
    EXPECT_TRUE(estimate.clean);
  }
}

TEST(RobustBias, BeginsAtAKnownBiasAndIsNotHeldThere) {
  ExactWindowOptions options = noisy(3);
  options.gyro_bias = Vector3d(0.5, -0.4, 0.5);
  const ExactWindow exact = makeExactWindow(options);
  for (const double error : {0.0, 0.03}) {
    Calibration calibration = exact.calibration;
    calibration.imu_biases.gyro = options.gyro_bias + Vector3d(error, 0.0, -error);
    calibration.imu_biases.gyro_sigma = 1e-4;
    const auto window = madeWindow(calibration, exact.keyframes, exact.imu);
    EXPECT_LT(relativeError(robustBiasOf(*window).gyro_bias, options.gyro_bias), 5e-3) << error;
  }
}

TEST(RobustBias, CleanNoiseKeepsNearlyEverything) {
  std::vector<double> errors, kept;
  for (unsigned seed = 1; seed <= kWindows; ++seed) {
    const ExactWindowOptions options = noisy(seed);
    const ExactWindow exact = makeExactWindow(options);
    const RobustBias estimate = robustBiasOf(*exact.window);
    ASSERT_TRUE(estimate.valid());
    errors.push_back(relativeError(estimate.gyro_bias, options.gyro_bias));
    kept.push_back(estimate.inlierFraction());
    // A pixel is a smaller angle at the rim of the image than at its centre.
    EXPECT_GT(estimate.cost, 0.5) << "seed " << seed;
    EXPECT_LT(estimate.cost, 1.0) << "seed " << seed;
  }
  EXPECT_LT(median(errors), 0.02);
  EXPECT_LT(*std::max_element(errors.begin(), errors.end()), 0.08);
  EXPECT_GT(median(kept), 0.98);
}

TEST(RobustBias, ThirtyPercentRandomOutliers) {
  std::vector<double> errors;
  int moved = 0, moved_kept = 0, good = 0, good_dropped = 0;
  for (unsigned seed = 1; seed <= kWindows; ++seed) {
    const ExactWindowOptions options = noisy(seed);
    const Corrupted corrupted = withRandomOutliers(makeExactWindow(options), 0.3, seed);
    const RobustBias estimate = robustBiasOf(*corrupted.window);
    ASSERT_TRUE(estimate.valid());
    errors.push_back(relativeError(estimate.gyro_bias, options.gyro_bias));
    for (const Track& track : corrupted.window->pointTracks()) {
      for (int a = track.begin; a < track.end; ++a) {
        const int keyframe = corrupted.window->pointObservations()[a].keyframe;
        const bool kept = estimate.pruning.keep[a] != kDropObservation;
        if (corrupted.moved.count({track.id, keyframe}) > 0) {
          ++moved;
          moved_kept += kept ? 1 : 0;
        } else {
          ++good;
          good_dropped += kept ? 0 : 1;
        }
      }
    }
  }
  EXPECT_LT(median(errors), 0.10);
  // Of displacements of 20 px the part across the epipolar line is below the 3 px that pass in one
  // case out of eight.
  EXPECT_LT(moved_kept, 0.3 * moved);
  EXPECT_LT(good_dropped, 0.3 * good);
}

TEST(RobustBias, CoherentOutliers) {
  std::vector<double> robust, plain;
  for (unsigned seed = 1; seed <= kWindows; ++seed) {
    const ExactWindowOptions options = noisy(seed);
    const Corrupted corrupted = withCoherentOutliers(makeExactWindow(options), 0.15, seed);
    const RobustBias estimate = robustBiasOf(*corrupted.window);
    ASSERT_TRUE(estimate.valid());
    const std::vector<char>& keep = estimate.pruning.keep;
    EXPECT_GT(std::count(keep.begin(), keep.end(), kDropObservation), 0);
    robust.push_back(relativeError(estimate.gyro_bias, options.gyro_bias));
    plain.push_back((unprunedBias(*corrupted.window) - options.gyro_bias).norm() /
                    options.gyro_bias.norm());
  }
  EXPECT_LT(median(robust), 0.15);
  EXPECT_LT(median(robust), 0.7 * median(plain));
}

TEST(RobustBias, PureRotationAndHoverGiveTheBias) {
  for (const Motion motion : {Motion::kPureRotation, Motion::kHover}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      ExactWindowOptions options = noisy(seed);
      options.motion = motion;
      const ExactWindow exact = makeExactWindow(options);
      const RobustBias estimate = robustBiasOf(*exact.window);
      ASSERT_TRUE(estimate.valid());
      EXPECT_LT(relativeError(estimate.gyro_bias, options.gyro_bias), 0.1) << "seed " << seed;
    }
  }
}

TEST(RobustBias, RefusesWithoutPoints) {
  ExactWindowOptions options;
  options.points = 3;
  const RobustBias estimate = robustBiasOf(*makeExactWindow(options).window);
  EXPECT_EQ(estimate.status, InitStatus::kTooFewTracks);
  EXPECT_FALSE(estimate.valid());
}

TEST(RobustBias, RefusesWithoutConsensus) {
  // Bearings drawn anew in every keyframe.
  const ExactWindowOptions options = noisy(1);
  const ExactWindow exact = makeExactWindow(options);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-0.6, 0.6);
  std::vector<FrameObservation> frames = exact.keyframes;
  for (FrameObservation& frame : frames) {
    for (PointObservation& point : frame.points) {
      const double x = uniform(random), y = uniform(random);
      point.bearing = Vector3d(x, y, 1.0).normalized();
    }
  }
  const RobustBias estimate = robustBiasOf(*windowOf(exact, frames));
  EXPECT_FALSE(estimate.valid());
}

}  // namespace
}  // namespace slim_init
