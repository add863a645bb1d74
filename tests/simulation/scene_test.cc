// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/scene.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

#include "support/method_name.h"
#include "support/text_parts.h"

namespace slim_init::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kTolerance = 1e-12;

Solid box(const Vector3d& center, const Vector3d& half_size, double yaw_deg = 0.0) {
  Solid solid;
  solid.name = "box";
  solid.center = center;
  solid.half_size = half_size;
  solid.yaw_deg = yaw_deg;
  return solid;
}

Scene sceneOf(std::vector<Solid> solids) {
  Scene scene;
  scene.kind = "test";
  scene.looks = {Look()};
  scene.solids = std::move(solids);
  return scene;
}

TEST(CastRay, MeetsTheNearFaceOfABox) {
  const Scene scene = sceneOf({box({5, 0, 0}, {1, 2, 3}), box({3, 0, 0}, {0.5, 0.1, 0.1})});
  const RayHit near = scene.castRay(Vector3d::Zero(), Vector3d(2, 0, 0));
  ASSERT_TRUE(near.hit());
  EXPECT_EQ(near.solid, 1);
  EXPECT_EQ(near.face, 0);  // lower side of axis x
  EXPECT_NEAR(near.distance, 2.5, kTolerance);
  EXPECT_LT((near.point_w - Vector3d(2.5, 0, 0)).norm(), kTolerance);
  EXPECT_LT((near.normal_w - Vector3d(-1, 0, 0)).norm(), kTolerance);

  const RayHit past = scene.castRay(Vector3d(0, 1, 0), Vector3d::UnitX());
  EXPECT_EQ(past.solid, 0);
  EXPECT_NEAR(past.distance, 4.0, kTolerance);
  EXPECT_FALSE(scene.castRay(Vector3d::Zero(), -Vector3d::UnitX()).hit());
  EXPECT_FALSE(scene.castRay(Vector3d::Zero(), Vector3d::UnitZ()).hit());
  EXPECT_FALSE(scene.castRay(Vector3d::Zero(), Vector3d::Zero()).hit());
}

TEST(CastRay, FromInsideMeetsTheFarSide) {
  const Scene scene = sceneOf({box({0, 0, 0}, {1, 2, 3})});
  const RayHit hit = scene.castRay(Vector3d(0.5, 0, 0), Vector3d::UnitY());
  EXPECT_EQ(hit.face, 3);
  EXPECT_NEAR(hit.distance, 2.0, kTolerance);
}

TEST(CastRay, TurnedBox) {
  // A cube turned by 45 deg shows its upright edge at half its diagonal.
  const Scene scene = sceneOf({box({5, 0, 0}, {1, 1, 1}, 45.0)});
  const RayHit hit = scene.castRay(Vector3d(0, 1e-9, 0), Vector3d::UnitX());
  EXPECT_NEAR(hit.distance, 5.0 - std::sqrt(2.0), 1e-8);
  EXPECT_NEAR(std::abs(hit.normal_w.x()), std::sqrt(0.5), kTolerance);
  // At a point of the surface, the normal is at right angles to the face: another ray to the same
  // face meets the same plane.
  const RayHit other = scene.castRay(Vector3d(0, 0.3, 0.2), Vector3d::UnitX());
  ASSERT_EQ(other.face, hit.face);
  EXPECT_NEAR((other.point_w - hit.point_w).dot(hit.normal_w), 0.0, 1e-8);
}

TEST(CastRay, Cylinder) {
  Solid pipe = box({5, 0, 0}, {0.5, 0.5, 2.0});
  pipe.shape = Shape::kCylinder;
  pipe.axis = 2;
  const Scene scene = sceneOf({pipe});
  const RayHit front = scene.castRay(Vector3d(0, 0.3, 0), Vector3d::UnitX());
  ASSERT_TRUE(front.hit());
  EXPECT_EQ(front.face, 6);
  EXPECT_NEAR(front.distance, 5.0 - 0.4, kTolerance);  // 3-4-5
  EXPECT_LT((front.normal_w - Vector3d(-0.8, 0.6, 0.0)).norm(), kTolerance);
  EXPECT_FALSE(scene.castRay(Vector3d(0, 0.51, 0), Vector3d::UnitX()).hit());
  const RayHit top = scene.castRay(Vector3d(5, 0.1, 5), -Vector3d::UnitZ());
  EXPECT_EQ(top.face, 5);
  EXPECT_NEAR(top.distance, 3.0, kTolerance);
  // Inside the bounding box, outside the circle.
  EXPECT_FALSE(scene.castRay(Vector3d(5.4, 0.4, 5), -Vector3d::UnitZ()).hit());
}

TEST(Visible, IsStoppedByWhatStandsBetween) {
  const Scene scene = sceneOf({box({5, 0, 0}, {0.1, 5, 5}), box({2, 0, 0}, {0.1, 0.5, 0.5})});
  EXPECT_FALSE(scene.visible(Vector3d::Zero(), Vector3d(4.9, 0, 0)));
  EXPECT_TRUE(scene.visible(Vector3d::Zero(), Vector3d(4.9, 3, 0)));
  EXPECT_TRUE(scene.visible(Vector3d::Zero(), Vector3d(1.9, 0, 0)));
}

TEST(Clearance, IsTheDistanceToTheNearestSurface) {
  Solid pipe = box({0, 0, 0}, {0.5, 0.5, 2.0});
  pipe.shape = Shape::kCylinder;
  const Scene scene = sceneOf({box({5, 0, 0}, {1, 1, 1}, 30.0), pipe});
  EXPECT_NEAR(scene.clearance(Vector3d(0, 1.5, 0)), 1.0, kTolerance);
  EXPECT_NEAR(scene.clearance(Vector3d(0, 0.5 + 3.0, 2.0 + 4.0)), 5.0, kTolerance);
  EXPECT_NEAR(scene.clearance(Vector3d(0.2, 0, 0)), -0.3, kTolerance);
  EXPECT_NEAR(scene.clearance(Vector3d(5, 0, 1.7)), 0.7, kTolerance);
}

TEST(Edges, OfABoxAndNotOfWhatIsBuried) {
  EXPECT_EQ(sceneOf({box({0, 0, 0}, {1, 2, 3}, 20.0)}).edges().size(), 12u);
  // A small box inside a large one has no edge to be seen.
  const Scene scene = sceneOf({box({0, 0, 0}, {1, 2, 3}), box({0, 0, 0}, {0.5, 0.5, 0.5})});
  const std::vector<SceneEdge> edges = scene.edges();
  ASSERT_EQ(edges.size(), 12u);
  double length = 0.0;
  for (const SceneEdge& edge : edges) {
    EXPECT_EQ(edge.solid, 0);
    length += (edge.end_w - edge.start_w).norm();
  }
  EXPECT_NEAR(length, 4.0 * (2 + 4 + 6), kTolerance);
}

TEST(SceneJson, RoundTripKeepsEveryBit) {
  for (const std::string& kind : sceneNames()) {
    Scene scene;
    ASSERT_TRUE(
        makeScene({kind, 3}, {Vector3d(0.1, 0.2, 1.3), Vector3d(3, -1, 1.6)}, &scene, nullptr));
    const std::string text = sceneToJson(scene);
    Scene read;
    std::string error;
    ASSERT_TRUE(sceneFromJson(text, &read, &error)) << error;
    EXPECT_EQ(sceneToJson(read), text);
    ASSERT_EQ(read.solids.size(), scene.solids.size());
    for (std::size_t i = 0; i < read.solids.size(); ++i) {
      EXPECT_EQ(read.solids[i].center, scene.solids[i].center);
      EXPECT_EQ(read.solids[i].yaw_deg, scene.solids[i].yaw_deg);
    }
  }
}

TEST(SceneJson, BadTextIsRefusedWithTheElementAtFault) {
  const std::string good = sceneToJson(sceneOf({box({0, 0, 0}, {1, 1, 1})}));
  const auto refused = [&](const std::string& from, const std::string& to,
                           const std::string& part) {
    std::string text = good;
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    Scene scene = sceneOf({});
    std::string error;
    EXPECT_FALSE(sceneFromJson(text, &scene, &error)) << to;
    EXPECT_TRUE(contains(error, part)) << "\"" << part << "\" in: " << error;
    EXPECT_TRUE(scene.solids.empty());
  };
  refused("slim_init scene 1", "slim_init scene 2", "format");
  refused("\"plain\"", "\"paisley\"", "looks[0]: pattern 'paisley' is not known");
  refused("\"shape\": \"box\"", "\"shape\": \"ball\"", "solids[0]: shape 'ball' is not known");
  refused("\"yaw_deg\": 0.0", "\"yaw_deg\": 1000.0", "solids[0].yaw_deg is 1000");
  refused("\"look\": 0", "\"look\": 7", "solids[0].look is 7, must be in [0, 0]");
  refused("\"axis\"", "\"axle\"", "solids[0]");
  refused("{", "", "not a scene");
  Scene scene;
  std::string error;
  EXPECT_FALSE(sceneFromJson("", &scene, &error));
  EXPECT_FALSE(error.empty());
}

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

TEST_P(BuiltScene, IsValidAndKeepsItsDistanceFromThePath) {
  // The corridor's handrail stands 9 cm out of a wall that is 0.5 m away; a turned crate's corner
  // stays inside the footprint that was kept clear.
  const double kMinClearance = 0.3;
  for (const unsigned seed : {1U, 2U, 3U}) {
    Scene scene;
    std::string error;
    ASSERT_TRUE(makeScene({GetParam(), seed}, path(), &scene, &error)) << error;
    EXPECT_EQ(scene.validate(), "");
    EXPECT_EQ(scene.kind, GetParam());
    for (const Vector3d& place : path()) {
      ASSERT_GT(scene.clearance(place), kMinClearance) << place.transpose() << " seed " << seed;
    }
  }
}

TEST_P(BuiltScene, IsClosed) {
  Scene scene;
  ASSERT_TRUE(makeScene({GetParam(), 1}, path(), &scene, nullptr));
  std::mt19937 engine(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d direction{normal(engine), normal(engine), normal(engine)};
    const RayHit hit = scene.castRay(path()[static_cast<std::size_t>(i % 400)], direction);
    ASSERT_TRUE(hit.hit()) << direction.transpose();
    // The normal looks back at whoever sees the surface.
    ASSERT_LT(hit.normal_w.dot(direction), 0.0);
  }
}

TEST_P(BuiltScene, SeedDecides) {
  Scene a, b, c;
  ASSERT_TRUE(makeScene({GetParam(), 5}, path(), &a, nullptr));
  ASSERT_TRUE(makeScene({GetParam(), 5}, path(), &b, nullptr));
  ASSERT_TRUE(makeScene({GetParam(), 6}, path(), &c, nullptr));
  EXPECT_EQ(sceneToJson(a), sceneToJson(b));
  EXPECT_NE(sceneToJson(a), sceneToJson(c));
}

INSTANTIATE_TEST_SUITE_P(All, BuiltScene, testing::ValuesIn(sceneNames()),
                         testing_support::methodTestName);

TEST(MakeScene, CorridorLiesAlongThePath) {
  for (const int axis : {0, 1}) {
    Vector3d end(0, 0, 1.5);
    end[axis] = 20.0;
    Scene scene;
    ASSERT_TRUE(makeScene({"corridor", 1}, {Vector3d(0, 0, 1.5), end}, &scene, nullptr));
    const Vector3d size = scene.hull.max - scene.hull.min;
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
