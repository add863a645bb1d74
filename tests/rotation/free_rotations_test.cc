// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/free_rotations.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "geometry/so3.h"
#include "slim_init/init_window.h"
#include "support/drawn_vector.h"
#include "support/exact_window.h"

namespace slim_init {
namespace {

constexpr int kKeyframes = 6;
constexpr int kPoints = 120;
constexpr int kGap = 2;
constexpr int kPairs = kKeyframes - kGap;
constexpr int kDraws = 20;
constexpr double kNear = 0.01;  // [rad]: noise of 0.6 px and a narrow view

// A camera that does not turn moves by `step` [m] an image along a random direction, before points
// at 3 m, `depth` more or less.
std::shared_ptr<const InitWindow> movingWindow(double depth, double step, std::mt19937* random) {
  constexpr double kFocalPx = 460.0, kNoisePx = 0.6, kDistance = 3.0;
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Eigen::Vector3d along = drawnVector([&] { return normal(*random); }).normalized();
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector3d drawn = drawnVector([&] { return uniform(*random); });
    points.emplace_back(2.4 * drawn.x(), 1.5 * drawn.y(), kDistance + depth * drawn.z());
  }
  std::vector<FrameObservation> frames(kKeyframes);
  for (int k = 0; k < kKeyframes; ++k) {
    frames[k].t = 0.1 * k;
    for (int i = 0; i < kPoints; ++i) {
      const Eigen::Vector3d seen = points[i] - k * step * along;
      const double noise_y = normal(*random), noise_x = normal(*random);
      const Eigen::Vector3d noise(noise_x, noise_y, 0.0);
      PointObservation point;
      point.id = i;
      point.bearing = (seen / seen.z() + kNoisePx / kFocalPx * noise).normalized();
      point.pixel = kFocalPx * point.bearing.hnormalized();
      frames[k].points.push_back(point);
    }
  }
  std::vector<ImuSample> imu;
  for (int i = -20; i < 130; ++i) {
    ImuSample sample;
    sample.t = 0.005 * i;
    sample.gyro.setZero();
    sample.accel = Eigen::Vector3d(0.0, 0.0, 9.81);
    imu.push_back(sample);
  }
  return madeWindow(Calibration(), frames, imu);
}

struct Freed {
  int found = 0;  // of kDraws * kPairs
  int right = 0;  // within kNear of the truth
};

// From a gyroscope that is wrong by `wrong` [rad] in every pair.
Freed freed(double depth, double step, double wrong) {
  constexpr int kMaxGap = 8;
  Freed out;
  for (unsigned seed = 1; seed <= kDraws; ++seed) {
    std::mt19937 random(seed);
    const auto window = movingWindow(depth, step, &random);
    if (window == nullptr) continue;
    std::normal_distribution<double> normal;
    const Eigen::Vector3d error = wrong * drawnVector([&] { return normal(random); }).normalized();
    const KeyframePairs pairs(*window, kMaxGap);
    PairRotation rotation;
    rotation.R_ci_cj = expSO3(error);
    for (const RotationCorrection& pair :
         freeRotations(pairs, PairRotations(pairs.size(), rotation), unknownBaselines(pairs), kGap,
                       kFreeFromFar)) {
      ++out.found;
      out.right += (pair.phi + error).norm() < kNear;
    }
  }
  return out;
}

// A rotation that is off by more than the parallax leaves directions without curvature. Before a
// step beyond all bounds was replaced, between 32 and 44 of 80 pairs had a rotation before a wall.
// Of 2000 pairs 85 to 92 % are right there.
TEST(FreeRotations, FindsRotationsOfLittleParallaxThatAreFarOff) {
  constexpr int kAll = kDraws * kPairs;
  for (const double depth : {0.0, 1.0}) {
    for (const double wrong : {0.005, 0.015, 0.03}) {
      const Freed result = freed(depth, 0.05, wrong);
      EXPECT_GE(result.found, kAll * 9 / 10) << "depth " << depth << " wrong " << wrong;
      EXPECT_GE(result.right, kAll * 9 / 10) << "depth " << depth << " wrong " << wrong;
    }
  }
}

TEST(FreeRotations, LeavesARightRotationWhereItIs) {
  const Freed result = freed(1.0, 0.1, 0.0);
  EXPECT_EQ(result.found, kDraws * kPairs);
  EXPECT_EQ(result.right, kDraws * kPairs);
}

// ---- relativeRotation()

constexpr double kSigma = 1e-3;  // half a pixel

/// Points before a camera that turns by `turn` [rad] and travels by `travel` [m].
struct Scene {
  Eigen::Vector3d turn = Eigen::Vector3d(0.03, -0.05, 0.04);
  Eigen::Vector3d travel = Eigen::Vector3d(0.15, 0.05, -0.1);
  double noise = 0.0;     ///< of bearings [rad]
  double outliers = 0.0;  ///< share of points
  double depth = 3.0;     ///< of the nearest [m]
  double relief = 4.0;    ///< of the farthest behind the nearest [m]

  PairPoints points(unsigned seed, int count = 100) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    PairPoints pairs;
    const Eigen::Matrix3d R_ci_cj = expSO3(turn);
    const auto noisy = [&](const Eigen::Vector3d& f) {
      const Eigen::Vector3d n{gauss(random), gauss(random), gauss(random)};
      return (f.normalized() + noise * n).normalized();
    };
    for (int k = 0; k < count; ++k) {
      const double z = depth + relief * (0.5 + 0.5 * uniform(random));
      const Eigen::Vector3d p_i{0.8 * uniform(random) * z, 0.5 * uniform(random) * z, z};
      Eigen::Vector3d p_j = R_ci_cj.transpose() * (p_i - travel);
      if (uniform(random) * 0.5 + 0.5 < outliers) p_j += 0.3 * Eigen::Vector3d::Random();
      pairs.add(noisy(p_i), noisy(p_j));
    }
    return pairs;
  }
  double error(const RelativeRotation& result) const {
    return logSO3(expSO3(turn).transpose() * result.R_ci_cj).norm();
  }
};

TEST(PairRotation, IsExactWithoutNoise) {
  const Scene scene;
  RelativeRotation result;
  ASSERT_TRUE(relativeRotation(scene.points(1), kSigma, &result));
  EXPECT_LT(scene.error(result), 1e-6);
}

TEST(PairRotation, ErrorIsWhatTheInformationSays) {
  Scene scene;
  scene.noise = kSigma;
  double chi2 = 0.0;
  constexpr int kRuns = 200;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    RelativeRotation result;
    ASSERT_TRUE(relativeRotation(scene.points(seed), kSigma, &result));
    const Eigen::Vector3d error = logSO3(result.R_ci_cj.transpose() * expSO3(scene.turn));
    chi2 += error.dot(result.information * error);
    EXPECT_NEAR(result.residual, kSigma, 0.5 * kSigma);
  }
  // Three degrees of freedom, a little more for the robust scale. A bias shows here: with the
  // variances of the residuals held fixed it is 12.
  EXPECT_GT(chi2 / kRuns, 2.4);
  EXPECT_LT(chi2 / kRuns, 4.5);
}

int rightOfFifty(const Scene& scene) {
  int right = 0;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    RelativeRotation result;
    EXPECT_TRUE(relativeRotation(scene.points(seed), kSigma, &result));
    right += scene.error(result) < 0.005 ? 1 : 0;
  }
  return right;
}

TEST(PairRotation, SurvivesOutliers) {
  Scene scene;
  scene.noise = 0.5 * kSigma;
  scene.outliers = 0.1;  // many more than a front end's own rejection leaves
  EXPECT_GE(rightOfFifty(scene), 45);
}

TEST(PairRotation, TellsSidewaysTravelFromATurn) {
  // Travel that moves every point the same way, and a turn that undoes it in the mean.
  Scene scene;
  scene.noise = 0.3 * kSigma;
  scene.travel = Eigen::Vector3d(0.25, 0.0, 0.0);
  scene.turn = Eigen::Vector3d(0.0, 0.05, 0.0);
  EXPECT_GE(rightOfFifty(scene), 48);
}

TEST(PairRotation, NeedsNoParallax) {
  Scene scene;
  scene.noise = 0.3 * kSigma;
  scene.travel.setZero();
  RelativeRotation result;
  ASSERT_TRUE(relativeRotation(scene.points(1), kSigma, &result));
  EXPECT_LT(scene.error(result), 0.003);
  scene.turn.setZero();
  ASSERT_TRUE(relativeRotation(scene.points(1), kSigma, &result));
  EXPECT_LT(scene.error(result), 0.003);
  EXPECT_LT(result.flow, kSigma);
}

TEST(PairRotation, RefusesAHandfulOfPoints) {
  RelativeRotation result;
  EXPECT_FALSE(relativeRotation(Scene().points(1, 7), kSigma, &result));
  EXPECT_TRUE(relativeRotation(Scene().points(1, 12), kSigma, &result));
}

}  // namespace
}  // namespace slim_init
