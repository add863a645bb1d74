// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>

#include "lines/vanishing_point.h"

namespace slim_init {
namespace {

constexpr double kUnitNormTolerance = 4e-16;
constexpr double kRadPerDeg = 0.017453292519943295;

// Angle of d to the nearest direction up to sign [rad].
double distanceToGrid(const std::vector<Eigen::Vector3d>& directions, const Eigen::Vector3d& d) {
  double cosine = 0.0;
  for (const Eigen::Vector3d& direction : directions) {
    cosine = std::max(cosine, std::abs(direction.dot(d)));
  }
  return std::acos(std::min(1.0, cosine));
}

TEST(Icosphere, HasOneDirectionOfEachAntipodalPairOfVertices) {
  for (int level = 0; level <= 6; ++level) {
    const std::size_t vertices = 10 * (std::size_t{1} << (2 * level)) + 2;
    EXPECT_EQ(icosphereHemisphere(level).size(), vertices / 2) << "level " << level;
  }
  EXPECT_EQ(icosphereHemisphere(4).size(), 1281U);
}

TEST(Icosphere, DirectionsAreUnitAndFaceTheFront) {
  for (const Eigen::Vector3d& d : icosphereHemisphere(4)) {
    EXPECT_NEAR(d.norm(), 1.0, kUnitNormTolerance);
    EXPECT_GE(d.z(), 0.0);
  }
}

TEST(Icosphere, NoTwoDirectionsCoincideUpToSign) {
  const std::vector<Eigen::Vector3d>& directions = icosphereHemisphere(4);
  // The mean edge of level 4 is 63.4 deg / 16 = 4 deg; none is half as short.
  const double max_cosine = std::cos(2.0 * kRadPerDeg);
  int on_rim = 0;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (directions[i].z() == 0.0) ++on_rim;
    for (std::size_t j = i + 1; j < directions.size(); ++j) {
      ASSERT_LT(std::abs(directions[i].dot(directions[j])), max_cosine) << i << " and " << j;
    }
  }
  EXPECT_GT(on_rim, 0) << "without a direction at z = 0 this does not test the rim";
}

// The farthest direction is the middle of a face of the icosahedron: its circumradius there has the
// tangent 3 - sqrt(5), and every subdivision halves the tangent.
TEST(Icosphere, NoDirectionIsFarFromTheGrid) {
  constexpr double kAngleTolerance = 1e-12;
  for (int level = 0; level <= 4; ++level) {
    const std::vector<Eigen::Vector3d>& directions = icosphereHemisphere(level);
    const double bound_rad = std::atan((3.0 - std::sqrt(5.0)) / (1 << level));
    EXPECT_NEAR(distanceToGrid(directions, Eigen::Vector3d::Ones().normalized()), bound_rad,
                kAngleTolerance);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 5000; ++i) {
      const double x = normal(random);
      const double y = normal(random);
      const double z = normal(random);
      ASSERT_LT(distanceToGrid(directions, Eigen::Vector3d(x, y, z).normalized()),
                bound_rad + kAngleTolerance)
          << "level " << level;
    }
  }
}

TEST(Icosphere, LevelIsClamped) {
  EXPECT_EQ(&icosphereHemisphere(-3), &icosphereHemisphere(0));
  EXPECT_EQ(&icosphereHemisphere(99), &icosphereHemisphere(6));
}

TEST(Icosphere, ThreadsShareOneTable) {
  std::vector<const std::vector<Eigen::Vector3d>*> seen(8, nullptr);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    threads.emplace_back([&seen, i] { seen[i] = &icosphereHemisphere(5); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto* table : seen) EXPECT_EQ(table, &icosphereHemisphere(5));
}

}  // namespace
}  // namespace slim_init
