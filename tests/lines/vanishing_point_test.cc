// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Dominant vanishing point of one keyframe.
#include "lines/vanishing_point.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>
#include <numeric>

#include "lines/line_scene.h"
#include "support/gaussian.h"

namespace slim_init {
namespace {

// Small scenes: four lines within 2 deg suffice here, whatever the defaults ask for.
VanishingPointOptions fewLines() {
  VanishingPointOptions options;
  options.min_inliers = 4;
  options.inlier_threshold_deg = 2.0;
  return options;
}

using test::axisAngle;
using test::kRadPerDeg;
using test::segment;

constexpr double kSigmaLineRad = 0.7 / test::kFocalPx;  // the default of Calibration

constexpr double kExactRad = 1e-12;  // noise-free lines

const Eigen::Vector3d kCorridor = Eigen::Vector3d(0.1, -0.05, 1.0).normalized();
const Eigen::Vector3d kVertical = Eigen::Vector3d(0.05, 0.998, 0.06).normalized();

std::vector<WindowLine> joined(std::vector<WindowLine> a, const std::vector<WindowLine>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(VanishingPoint, IsExactForNoiseFreeLinesInEveryDirection) {
  std::mt19937 random(1);
  std::vector<Eigen::Vector3d> directions = {Eigen::Vector3d::UnitZ(),
                                             Eigen::Vector3d::UnitY(),
                                             Eigen::Vector3d::UnitX(),
                                             kCorridor,
                                             kVertical,
                                             Eigen::Vector3d(0.7, 0.1, 0.01).normalized(),
                                             Eigen::Vector3d(-0.5, 0.5, 0.7).normalized()};
  Gaussian normal(2);
  for (int trial = 0; trial < 500; ++trial) directions.push_back(normal.vector().normalized());
  for (const Eigen::Vector3d& truth : directions) {
    const auto lines = test::linesToward(truth, 12, random);
    const VanishingPoint vp = estimateVanishingPoint(lines, kSigmaLineRad, fewLines());
    ASSERT_TRUE(vp.found) << truth.transpose();
    EXPECT_LT(axisAngle(vp.direction, truth), kExactRad) << truth.transpose();
    EXPECT_NEAR(vp.direction.norm(), 1.0, kExactRad);
    EXPECT_GE(vp.direction.z(), 0.0);
    EXPECT_EQ(vp.inliers.size(), lines.size());
    EXPECT_EQ(vp.track_id, -1);
    EXPECT_EQ(vp.age, 0);
  }
}

// 12 lines on the vanishing point, clutter that misses it by more than 5 deg. Without noise the
// clutter must leave no trace at all.
TEST(VanishingPoint, IgnoresClutter) {
  constexpr int kTrials = 100;
  for (const int clutter_count : {5, 12}) {  // 30 % and 50 %
    for (const Eigen::Vector3d& truth : {kCorridor, kVertical}) {
      std::mt19937 random(3);
      for (int trial = 0; trial < kTrials; ++trial) {
        const auto good = test::linesToward(truth, 12, random);
        const auto bad = test::clutter(truth, 5.0 * kRadPerDeg, clutter_count, random);
        const VanishingPoint vp =
            estimateVanishingPoint(joined(bad, good), kSigmaLineRad, fewLines());
        ASSERT_TRUE(vp.found) << clutter_count << " clutter lines, trial " << trial;
        EXPECT_LT(axisAngle(vp.direction, truth), kExactRad)
            << clutter_count << " clutter lines, trial " << trial;
        std::vector<int> expected(12);
        std::iota(expected.begin(), expected.end(), clutter_count);
        EXPECT_EQ(vp.inliers, expected);
      }
    }
  }
}

TEST(VanishingPoint, OfTwoAxesTheHeavierOneWins) {
  std::mt19937 random(5);
  // Lines of one axis that miss the other, so that the weights are known.
  const auto only = [&random](const Eigen::Vector3d& axis, const Eigen::Vector3d& other, int count,
                              double length_px) {
    std::vector<WindowLine> lines;
    while (static_cast<int>(lines.size()) < count) {
      WindowLine line = test::linesToward(axis, 1, random).front();
      if (std::abs(line.normal.dot(other)) < std::sin(6.0 * kRadPerDeg)) continue;
      line.length_px = length_px;
      lines.push_back(line);
    }
    return lines;
  };
  for (int trial = 0; trial < 20; ++trial) {
    // 5 x 260 > 9 x 100: few long lines win.
    auto vertical = only(kVertical, kCorridor, 9, 100.0);
    auto vp = estimateVanishingPoint(joined(only(kCorridor, kVertical, 5, 260.0), vertical),
                                     kSigmaLineRad, fewLines());
    ASSERT_TRUE(vp.found);
    EXPECT_LT(axisAngle(vp.direction, kCorridor), kExactRad);
    // 5 x 120 < 9 x 100.
    vertical = only(kVertical, kCorridor, 9, 100.0);
    vp = estimateVanishingPoint(joined(only(kCorridor, kVertical, 5, 120.0), vertical),
                                kSigmaLineRad, fewLines());
    ASSERT_TRUE(vp.found);
    EXPECT_LT(axisAngle(vp.direction, kVertical), kExactRad);
  }
}

TEST(VanishingPoint, NeedsMinInliers) {
  std::mt19937 random(6);
  VanishingPointOptions options;
  const auto lines = test::linesToward(kCorridor, options.min_inliers, random);
  EXPECT_TRUE(estimateVanishingPoint(lines, kSigmaLineRad, options).found);

  const std::vector<WindowLine> too_few(lines.begin() + 1, lines.end());
  EXPECT_FALSE(estimateVanishingPoint(too_few, kSigmaLineRad, options).found);
  EXPECT_FALSE(estimateVanishingPoint({}, kSigmaLineRad, options).found);
  // Lines that miss every common direction do not add up to one.
  auto scattered = too_few;
  scattered.push_back(
      segment(Eigen::Vector3d(0.3, 0.3, 1.0), Eigen::Vector3d(1.0, -1.0, 0.0), 0.3));
  ASSERT_GT(std::abs(scattered.back().normal.dot(kCorridor)), std::sin(10.0 * kRadPerDeg));
  EXPECT_FALSE(estimateVanishingPoint(scattered, kSigmaLineRad, options).found);

  options.min_inliers = 3;
  EXPECT_TRUE(estimateVanishingPoint(too_few, kSigmaLineRad, options).found);
}

TEST(VanishingPoint, LinesWithoutLengthTakeNoPart) {
  std::mt19937 random(7);
  auto lines = test::linesToward(kCorridor, 5, random);
  for (const double length : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    lines[1].length_px = length;
    const VanishingPoint vp = estimateVanishingPoint(lines, kSigmaLineRad, fewLines());
    ASSERT_TRUE(vp.found) << length;
    EXPECT_EQ(vp.inliers, (std::vector<int>{0, 2, 3, 4}));
    EXPECT_LT(axisAngle(vp.direction, kCorridor), kExactRad);
  }
  lines[2].length_px = -1.0;
  EXPECT_FALSE(estimateVanishingPoint(lines, kSigmaLineRad, fewLines()).found);
  for (WindowLine& line : lines) line.length_px = 0.0;
  EXPECT_FALSE(estimateVanishingPoint(lines, kSigmaLineRad, fewLines()).found);
}

// Image-vertical lines side by side: the plane of one differs from that of the next by their
// distance in the image alone.
std::vector<WindowLine> verticalLines(double half_spread_rad) {
  std::vector<WindowLine> lines;
  for (int i = 0; i < 9; ++i) {
    const double azimuth = half_spread_rad * (i - 4) / 4.0;
    lines.push_back(segment(Eigen::Vector3d(std::sin(azimuth), 0.02 * (i % 3), std::cos(azimuth)),
                            Eigen::Vector3d::UnitY(), 0.3));
  }
  return lines;
}

TEST(VanishingPoint, BundleOfParallelImageLinesIsRefused) {
  // For a direction at right angles to a segment of angle h, a = -b = 1 / (2 sin(h / 2)) in
  // a^2 + b^2. The planes' mean square spread is that of sin(azimuth): 5/12 of half_spread^2.
  const double amplification = 0.5 / std::pow(std::sin(0.15), 2);
  const double bound_rad = std::sqrt(10.0 * amplification * 12.0 / 5.0) * kSigmaLineRad;
  EXPECT_NEAR(bound_rad / kRadPerDeg, 2.02, 0.01) << "the bound in terms one can picture";

  EXPECT_TRUE(
      estimateVanishingPoint(verticalLines(1.1 * bound_rad), kSigmaLineRad, fewLines()).found);
  EXPECT_FALSE(
      estimateVanishingPoint(verticalLines(0.9 * bound_rad), kSigmaLineRad, fewLines()).found);
  // The same by what the fit leaves, with no word about noise.
  std::mt19937 random(9);
  int found_wide = 0;
  int found_narrow = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const auto noisy = [&](double half_spread_rad) {
      return test::perturbed(verticalLines(half_spread_rad), kSigmaLineRad, random);
    };
    found_wide += estimateVanishingPoint(noisy(5.0 * bound_rad), 0.0, {}).found;
    found_narrow += estimateVanishingPoint(noisy(0.2 * bound_rad), 0.0, {}).found;
  }
  EXPECT_GE(found_wide, 95);
  EXPECT_LE(found_narrow, 5);
}

TEST(VanishingPoint, CoincidentPlanesAreRefusedWithoutNoise) {
  std::vector<WindowLine> lines;
  for (int i = 0; i < 8; ++i) {
    lines.push_back(segment(Eigen::Vector3d(0.1 * i - 0.35, 0.0, 1.0), Eigen::Vector3d::UnitX(),
                            0.1 + 0.02 * i));
  }
  EXPECT_FALSE(estimateVanishingPoint(lines, 0.0, {}).found);
  EXPECT_FALSE(estimateVanishingPoint(lines, kSigmaLineRad, fewLines()).found);
}

TEST(VanishingPoint, MinimisesEquation2WithLengthWeights) {
  std::mt19937 random(10);
  const auto lines =
      test::perturbed(test::linesToward(kCorridor, 15, random), kSigmaLineRad, random);
  const VanishingPoint vp = estimateVanishingPoint(lines, kSigmaLineRad, fewLines());
  ASSERT_TRUE(vp.found);
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Vector3d unweighted = Eigen::Vector3d::Zero();
  double length = 0.0;
  for (const int l : vp.inliers) {
    const double error = lines[l].normal.dot(vp.direction);
    gradient += lines[l].length_px * error * lines[l].normal;
    unweighted += error * lines[l].normal;
    length += lines[l].length_px;
  }
  constexpr double kStationary = 1e-15;
  EXPECT_LT((gradient / length).cross(vp.direction).norm(), kStationary);
  EXPECT_GT(unweighted.cross(vp.direction).norm(), 1e-4) << "this data cannot tell the weights";
}

TEST(VanishingPoint, InliersAreTheLinesWithinTheThreshold) {
  std::mt19937 random(11);
  const VanishingPointOptions options;
  for (int trial = 0; trial < 50; ++trial) {
    const auto clutter = test::clutter(kVertical, 0.0, 8, random);
    const auto lines = test::perturbed(joined(test::linesToward(kVertical, 14, random), clutter),
                                       kSigmaLineRad, random);
    const VanishingPoint vp = estimateVanishingPoint(lines, kSigmaLineRad, options);
    ASSERT_TRUE(vp.found);
    std::vector<int> expected;
    for (std::size_t l = 0; l < lines.size(); ++l) {
      if (std::abs(lines[l].normal.dot(vp.direction)) <
          std::sin(options.inlier_threshold_deg * kRadPerDeg)) {
        expected.push_back(static_cast<int>(l));
      }
    }
    EXPECT_EQ(vp.inliers, expected) << "trial " << trial;
  }
}

// Among clutter, where many directions compete: 226 of 300.
TEST(VanishingPoint, IsFoundAmongMuchClutter) {
  constexpr double kRightRad = 0.5 * kRadPerDeg;
  std::mt19937 random(12);
  VanishingPointOptions options;
  options.min_inliers = 2;
  int found = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto toward = test::linesToward(kCorridor, 6 + trial % 8, random);
    const auto lines = test::perturbed(joined(test::clutter(kCorridor, 0.0, 25, random), toward),
                                       kSigmaLineRad, random);
    const VanishingPoint vp = estimateVanishingPoint(lines, kSigmaLineRad, options);
    found += vp.found && axisAngle(vp.direction, kCorridor) < kRightRad ? 1 : 0;
  }
  EXPECT_GE(found, 215);
}

struct MonteCarloScene {
  const char* name;
  Eigen::Vector3d truth;
  std::vector<WindowLine> lines;
};

// Predicted against sample covariance, along both of its axes, and their rms normalised error.
TEST(VanishingPoint, CovarianceIsThatOfMonteCarlo) {
  constexpr double kMinRatio = 0.8;
  constexpr double kMaxRatio = 1.25;
  constexpr int kTrials = 3000;
  std::mt19937 random(15);
  std::vector<MonteCarloScene> scenes = {
      {"corridor", kCorridor, test::linesToward(kCorridor, 20, random)},
      {"vertical", kVertical, test::linesToward(kVertical, 12, random)},
      {"four lines", kCorridor, test::linesToward(kCorridor, 4, random)},
      {"narrow bundle", Eigen::Vector3d::UnitY(), verticalLines(6.0 * kRadPerDeg)}};
  // Length weights far from inverse variances: only the sandwich gets this one right.
  MonteCarloScene uneven{"uneven weights", kCorridor, test::linesToward(kCorridor, 12, random)};
  for (std::size_t l = 0; l < uneven.lines.size(); ++l) {
    uneven.lines[l].length_px *= l % 2 == 0 ? 0.2 : 5.0;
  }
  scenes.push_back(uneven);

  for (const MonteCarloScene& scene : scenes) {
    Eigen::Matrix3d sample = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d predicted = Eigen::Matrix3d::Zero();
    double normalised = 0.0;
    int found = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const VanishingPoint vp = estimateVanishingPoint(
          test::perturbed(scene.lines, kSigmaLineRad, random), kSigmaLineRad, fewLines());
      if (!vp.found) continue;
      ++found;
      const Eigen::Vector3d d =
          vp.direction.dot(scene.truth) < 0.0 ? Eigen::Vector3d(-vp.direction) : vp.direction;
      const Eigen::Vector3d error = d - scene.truth;
      sample += error * error.transpose();
      predicted += vp.covariance;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(vp.covariance);
      EXPECT_LT((vp.covariance * vp.direction).norm(), 1e-12 * vp.covariance.norm());
      EXPECT_GT(axes.eigenvalues()[1], 0.0);
      for (const int axis : {1, 2}) {
        normalised +=
            std::pow(axes.eigenvectors().col(axis).dot(error), 2) / axes.eigenvalues()[axis] / 2.0;
      }
    }
    ASSERT_GE(found, 0.99 * kTrials) << scene.name;
    sample /= found;
    predicted /= found;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(predicted);
    for (const int axis : {1, 2}) {
      const Eigen::Vector3d v = axes.eigenvectors().col(axis);
      const double ratio = v.dot(sample * v) / axes.eigenvalues()[axis];
      EXPECT_GT(ratio, kMinRatio) << scene.name << ", axis " << axis;
      EXPECT_LT(ratio, kMaxRatio) << scene.name << ", axis " << axis;
    }
    EXPECT_GT(normalised / found, kMinRatio) << scene.name;
    EXPECT_LT(normalised / found, kMaxRatio) << scene.name;
  }
}

TEST(VanishingPoint, CovarianceScalesWithTheNoise) {
  std::mt19937 random(16);
  const auto lines = test::linesToward(kCorridor, 10, random);
  const VanishingPoint one = estimateVanishingPoint(lines, 1e-3, {});
  const VanishingPoint two = estimateVanishingPoint(lines, 2e-3, {});
  ASSERT_TRUE(one.found && two.found);
  EXPECT_LT((4.0 * one.covariance - two.covariance).norm(), 1e-12 * two.covariance.norm());
  EXPECT_TRUE(estimateVanishingPoint(lines, 0.0, {}).covariance.isZero());
}

}  // namespace
}  // namespace slim_init
