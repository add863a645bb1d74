// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "simulation/ray_caster.h"
#include "support/gaussian.h"
#include "support/method_name.h"
#include "support/text_parts.h"

namespace slim_init::simulation {
namespace {

using Eigen::Vector3d;

class BuiltScene : public testing::TestWithParam<std::string> {
 protected:
  // A path that winds through 6 m by 4 m.
  static std::vector<Vector3d> path() {
    std::vector<Vector3d> places;
    for (int i = 0; i < 400; ++i) {
      const double t = 0.02 * i;
      places.emplace_back(3.0 * std::sin(t), 2.0 * std::sin(2.0 * t),
                          1.5 + 0.4 * std::cos(3.0 * t));
    }
    return places;
  }
};

TEST_P(BuiltScene, KeepsItsDistanceFromThePath) {
  // The corridor's handrail stands 9 cm out of a wall that is 0.5 m away; a turned crate's corner
  // stays inside the footprint that was kept clear.
  const double kMinClearance = 0.3;
  for (const unsigned seed : {1U, 2U, 3U}) {
    Scene scene;
    std::string error;
    ASSERT_TRUE(makeScene({GetParam(), seed}, path(), &scene, &error)) << error;
    for (const Solid& solid : scene.solids) {
      for (const Vector3d& place : path()) {
        const Vector3d p = toOwn(solid, place - solid.center).cwiseAbs() - solid.half_size;
        ASSERT_GT(p.cwiseMax(0.0).norm(), kMinClearance) << place.transpose() << " seed " << seed;
      }
    }
  }
}

TEST_P(BuiltScene, IsClosed) {
  Scene scene;
  ASSERT_TRUE(makeScene({GetParam(), 1}, path(), &scene, nullptr));
  Gaussian normal(7);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d direction = normal.vector();
    ASSERT_GE(firstSolid(scene, path()[static_cast<std::size_t>(i % 400)], direction), 0)
        << direction.transpose();
  }
}

TEST_P(BuiltScene, SeedDecides) {
  Scene a, b, c;
  ASSERT_TRUE(makeScene({GetParam(), 5}, path(), &a, nullptr));
  ASSERT_TRUE(makeScene({GetParam(), 5}, path(), &b, nullptr));
  ASSERT_TRUE(makeScene({GetParam(), 6}, path(), &c, nullptr));
  const auto numbers = [](const Scene& scene) {
    std::vector<double> all;
    for (const Solid& solid : scene.solids) {
      all.insert(all.end(), solid.center.begin(), solid.center.end());
      all.insert(all.end(), solid.half_size.begin(), solid.half_size.end());
      all.insert(all.end(), {solid.yaw_deg, static_cast<double>(solid.look)});
    }
    for (const Look& look : scene.looks) {
      all.insert(all.end(), {look.bright, look.dark, look.size_m, look.angle_deg, look.glow});
    }
    return all;
  };
  EXPECT_EQ(numbers(a), numbers(b));
  EXPECT_NE(numbers(a), numbers(c));
}

INSTANTIATE_TEST_SUITE_P(All, BuiltScene, testing::ValuesIn(sceneNames()), methodTestName);

TEST(MakeScene, CorridorLiesAlongThePath) {
  for (const int axis : {0, 1}) {
    Vector3d end(0, 0, 1.5);
    end[axis] = 20.0;
    Scene scene;
    ASSERT_TRUE(makeScene({"corridor", 1}, {Vector3d(0, 0, 1.5), end}, &scene, nullptr));
    const Vector3d size = scene.hull.max() - scene.hull.min();
    EXPECT_GT(size[axis], 30.0);
    EXPECT_LT(size[1 - axis], 2.5);
    int doors = 0;
    for (const Solid& solid : scene.solids) doors += solid.name == "door leaf" ? 1 : 0;
    EXPECT_GT(doors, 15);
  }
}

TEST(MakeScene, RefusesUnknownKindAndEmptyPath) {
  Scene scene;
  std::string error;
  EXPECT_FALSE(makeScene({"moon", 1}, {Vector3d::Zero()}, &scene, &error));
  expectParts(error, "'moon'|brick-room");
  EXPECT_FALSE(makeScene({"room", 1}, {}, &scene, &error));
  expectParts(error, "no finite position");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(makeScene({"room", 1}, {Vector3d(nan, 0, 0)}, &scene, &error));
  EXPECT_TRUE(scene.solids.empty());
}

}  // namespace
}  // namespace slim_init::simulation
