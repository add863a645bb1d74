// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slim_init::simulation {
namespace {

constexpr double kRounding = 1e-9;  // [m]

bool inside(const Box& box, const Eigen::Vector3d& p, double grow) {
  return (p.array() >= box.min().array() - grow).all() &&
         (p.array() <= box.max().array() + grow).all();
}

double wallDistance(const Box& hull, const Eigen::Vector3d& p) {
  return std::min((p - hull.min()).minCoeff(), (hull.max() - p).minCoeff());
}

// A loop of radius 1.5 m about (x, y, 1.5).
std::vector<Eigen::Vector3d> loop(double x = 0.0, double y = 0.0) {
  std::vector<Eigen::Vector3d> path;
  for (double a = 0.0; a < 6.28; a += 0.02) {
    path.emplace_back(x + 1.5 * std::cos(a), y + 1.5 * std::sin(a), 1.5 + 0.3 * std::sin(2 * a));
  }
  return path;
}

// A straight walk along an axis.
std::vector<Eigen::Vector3d> walk(int axis, double length) {
  std::vector<Eigen::Vector3d> path;
  for (double s = 0.0; s <= length; s += 0.05) {
    Eigen::Vector3d p(0.0, 0.0, 1.5);
    p[axis] += s;
    p[1 - axis] += 0.08 * std::sin(s);
    path.push_back(p);
  }
  return path;
}

// A diagonal path that fits no natural hull.
std::vector<Eigen::Vector3d> diagonal() {
  std::vector<Eigen::Vector3d> path;
  for (double s = 0.0; s <= 1.0; s += 0.002) path.emplace_back(30.0 * s, -25.0 * s, 12.0 * s);
  return path;
}

struct Case {
  const char* name;
  std::string kind;
  std::vector<Eigen::Vector3d> path;
  double margin;  // [m]
  double relief;  // [m]
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

std::vector<Case> cases() {
  return {
      {"room_loop", "room", loop(), 1.0, 0.8},
      {"room_diagonal", "room", diagonal(), 1.0, 0.8},
      {"hall_loop", "hall", loop(100.0, -50.0), 1.0, 0.8},
      {"hall_walk", "hall", walk(0, 30.0), 1.0, 0.8},
      {"corridor_x", "corridor", walk(0, 40.0), 0.5, 0.1},
      {"corridor_y", "corridor", walk(1, 40.0), 0.5, 0.1},
      {"corridor_diagonal", "corridor", diagonal(), 0.5, 0.1},
  };
}

WorldOptions optionsOf(const std::string& kind, unsigned seed = 1) {
  WorldOptions options;
  options.kind = kind;
  options.seed = seed;
  return options;
}

class EveryWorld : public testing::TestWithParam<Case> {};

TEST_P(EveryWorld, EverythingIsInsideTheHull) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const World world = makeWorld(optionsOf(GetParam().kind, seed), GetParam().path);
    for (const Eigen::Vector3d& p : world.points) ASSERT_TRUE(inside(world.hull, p, kRounding));
    for (const Segment& s : world.segments) {
      ASSERT_TRUE(inside(world.hull, s.start, kRounding)) << s.start.transpose();
      ASSERT_TRUE(inside(world.hull, s.end, kRounding)) << s.end.transpose();
    }
    for (const Box& box : world.obstacles) {
      EXPECT_TRUE((box.min().array() < box.max().array()).all());
      EXPECT_TRUE(inside(world.hull, box.min(), kRounding));
      EXPECT_TRUE(inside(world.hull, box.max(), kRounding));
    }
  }
}

TEST_P(EveryWorld, KeepsClearOfThePath) {
  constexpr double kObstacleClearance = 0.7;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const World world = makeWorld(optionsOf(GetParam().kind, seed), GetParam().path);
    for (const Eigen::Vector3d& p : GetParam().path) {
      ASSERT_GE(wallDistance(world.hull, p), GetParam().margin - kRounding);
      for (const Box& box : world.obstacles) ASSERT_GE(box.exteriorDistance(p), kObstacleClearance);
    }
  }
}

TEST_P(EveryWorld, PointsStandOnSurfacesAndNotInsideObstacles) {
  const World world = makeWorld(optionsOf(GetParam().kind), GetParam().path);
  int on_obstacle = 0;
  int off_wall = 0;
  for (const Eigen::Vector3d& p : world.points) {
    const bool on_box =
        std::any_of(world.obstacles.begin(), world.obstacles.end(),
                    [&](const Box& box) { return box.exteriorDistance(p) < kRounding; });
    const double from_wall = wallDistance(world.hull, p);
    if (on_box) {
      ++on_obstacle;
    } else {
      ASSERT_LE(from_wall, GetParam().relief);
      if (from_wall > kRounding) ++off_wall;
    }
    for (Box box : world.obstacles) {
      box.min().array() += 1e-6;
      box.max().array() -= 1e-6;
      ASSERT_FALSE(inside(box, p, 0.0)) << p.transpose();
    }
  }
  const int count = static_cast<int>(world.points.size());
  EXPECT_EQ(on_obstacle > 0, !world.obstacles.empty());
  // Half of the points on walls stand out; five standard deviations of that share.
  const int on_walls = count - on_obstacle;
  EXPECT_NEAR(static_cast<double>(off_wall) / on_walls, 0.5, 2.5 / std::sqrt(on_walls));
}

TEST_P(EveryWorld, SegmentsAreLongEnoughAndMostHaveManhattanDirections) {
  const World world = makeWorld(optionsOf(GetParam().kind), GetParam().path);
  int free = 0;
  for (const Segment& s : world.segments) {
    const Eigen::Vector3d d = (s.end - s.start).normalized();
    EXPECT_GE((s.end - s.start).norm(), 0.3 - kRounding);
    free += d.cwiseAbs().maxCoeff() < 1.0 - kRounding ? 1 : 0;
  }
  const double share = static_cast<double>(free) / static_cast<double>(world.segments.size());
  EXPECT_NEAR(share, GetParam().kind == "corridor" ? 0.05 : 0.30, 0.01);
}

TEST_P(EveryWorld, MostPointsAreVisibleFromThePath) {
  const World world = makeWorld(optionsOf(GetParam().kind), GetParam().path);
  int seen = 0;
  for (const Eigen::Vector3d& p : world.points) {
    for (std::size_t k = 0; k < GetParam().path.size(); k += 20) {
      if (world.visible(GetParam().path[k], p)) {
        ++seen;
        break;
      }
    }
  }
  EXPECT_GT(seen, 0.85 * static_cast<double>(world.points.size()));
}

TEST_P(EveryWorld, EqualSeedsGiveEqualBytesOfIndependentStreams) {
  WorldOptions options = optionsOf(GetParam().kind);
  const World world = makeWorld(options, GetParam().path);
  options.points = 100;
  const World few_points = makeWorld(options, GetParam().path);
  ASSERT_EQ(world.segments.size(), few_points.segments.size());
  for (std::size_t i = 0; i < world.segments.size(); ++i) {
    EXPECT_EQ(world.segments[i].start, few_points.segments[i].start);
    EXPECT_EQ(world.segments[i].end, few_points.segments[i].end);
  }
  const World other = makeWorld(optionsOf(GetParam().kind, 2), GetParam().path);
  EXPECT_NE(world.points, other.points);
  EXPECT_NE(world.segments.back().start, other.segments.back().start);
  options = optionsOf(GetParam().kind);
  options.segments = 7;
  EXPECT_EQ(world.points, makeWorld(options, GetParam().path).points);
}

INSTANTIATE_TEST_SUITE_P(Worlds, EveryWorld, testing::ValuesIn(cases()),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(World, HasTheNaturalSizeAndFurnitureOfItsKind) {
  const World room = makeWorld(optionsOf("room"), loop());
  EXPECT_TRUE((room.hull.max() - room.hull.min()).isApprox(Eigen::Vector3d(8, 8, 4), 1e-3));
  const World hall = makeWorld(optionsOf("hall"), loop());
  EXPECT_TRUE((hall.hull.max() - hall.hull.min()).isApprox(Eigen::Vector3d(20, 15, 8), 1e-3));
  const World corridor = makeWorld(optionsOf("corridor"), walk(1, 40.0));
  EXPECT_TRUE(
      (corridor.hull.max() - corridor.hull.min()).isApprox(Eigen::Vector3d(2, 60, 2.7), 2e-3));
  EXPECT_GE(room.obstacles.size(), 4U);
  EXPECT_GE(hall.obstacles.size(), 8U);
  EXPECT_TRUE(corridor.obstacles.empty());
}

TEST(World, CountsAreWhatWasAskedFor) {
  WorldOptions options;
  options.points = 1234;
  options.segments = 77;
  const World room = makeWorld(options, loop());
  EXPECT_EQ(room.points.size(), 1234U);
  EXPECT_EQ(room.segments.size(), 77U);
  options.points = 0;
  options.segments = 0;
  EXPECT_TRUE(makeWorld(options, loop()).points.empty());
  EXPECT_TRUE(makeWorld(options, loop()).segments.empty());
  options.points = -5;
  options.segments = -5;
  EXPECT_TRUE(makeWorld(options, loop()).points.empty());
}

TEST(World, CorridorDensityDoesNotDependOnItsLength) {
  const World one = makeWorld(optionsOf("corridor"), walk(0, 20.0));  // 40 m of hull
  const World two = makeWorld(optionsOf("corridor"), walk(0, 60.0));  // 80 m of hull
  EXPECT_NEAR(static_cast<double>(two.points.size()) / one.points.size(), 2.0, 0.05);
  EXPECT_NEAR(static_cast<double>(two.segments.size()) / one.segments.size(), 2.0, 0.05);
  EXPECT_NEAR(static_cast<double>(one.points.size()), 125.0, 6.0);     // 1.25 % of 5000, 400 m^2
  EXPECT_NEAR(static_cast<double>(one.segments.size()), 520.0, 25.0);  // 260 on 200 m^2
}

TEST(World, CorridorLinesRunAlongIt) {
  for (const int along : {0, 1}) {
    const World world = makeWorld(optionsOf("corridor"), walk(along, 60.0));
    int count[3] = {0, 0, 0};
    for (const Segment& s : world.segments) {
      const Eigen::Vector3d d = (s.end - s.start).normalized().cwiseAbs();
      int axis = 0;
      if (d.maxCoeff(&axis) > 1.0 - kRounding) ++count[axis];
    }
    EXPECT_GT(count[along], 3 * count[2]);
    EXPECT_GT(count[along], 3 * count[1 - along]);
    EXPECT_GT(count[2], 0);
    EXPECT_GT(count[1 - along], 0);
  }
}

TEST(World, CorridorOfAStillPathRunsAlongX) {
  // Millimetres of wobble, more of it in y, say nothing about a direction.
  const World world = makeWorld(optionsOf("corridor"),
                                {{0.001, -0.002, 1.5}, {0.0, 0.002, 1.5}, {-0.001, 0.0, 1.5}});
  EXPECT_GT(world.hull.max().x() - world.hull.min().x(), 19.0);
  EXPECT_LT(world.hull.max().y() - world.hull.min().y(), 2.1);
}

TEST(World, WithoutAPathStandsAboutTheOrigin) {
  const World world = makeWorld(optionsOf("room"), {});
  EXPECT_TRUE(inside(world.hull, Eigen::Vector3d::Zero(), -1.0));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Eigen::Vector3d> path = loop();
  const World clean = makeWorld(optionsOf("room"), path);
  path.insert(path.begin() + 10, Eigen::Vector3d(nan, 0.0, 0.0));
  EXPECT_EQ(clean.points, makeWorld(optionsOf("room"), path).points);
}

// A cube of 2 m about the origin in a hull of 20 m.
World cubeWorld() {
  World world;
  world.hull = {Eigen::Vector3d::Constant(-10.0), Eigen::Vector3d::Constant(10.0)};
  world.obstacles = {{Eigen::Vector3d::Constant(-1.0), Eigen::Vector3d::Constant(1.0)}};
  return world;
}

TEST(WorldVisible, ABoxHidesWhatIsBehindItAndWallsWhatIsOutside) {
  struct Ray {
    Eigen::Vector3d from, to;
    bool visible;
  };
  const World world = cubeWorld();
  for (const auto& [from, to, visible] : {
           // Behind the box, from both sides.
           Ray{{-5, 0, 0}, {5, 0, 0}, false},
           Ray{{5, 0, 0}, {-5, 0, 0}, false},
           Ray{{-5, -4, -3}, {5, 4, 3}, false},
           Ray{{0, 0, -9}, {0.5, 0.5, 10}, false},
           // Beside or before it; the last passes the corner.
           Ray{{-5, 1.1, 0}, {5, 1.1, 0}, true},
           Ray{{-5, 0, 0}, {-2, 0, 0}, true},
           Ray{{2, 0, 0}, {5, 0, 0}, true},
           Ray{{-5, 0, 0}, {0, 5, 0}, true},
           // Faces from their side only.
           Ray{{-5, 0.3, 0}, {-1, 0.2, 0.5}, true},  // front face
           Ray{{-5, 0.3, 0}, {1, 0.2, 0.5}, false},  // back face
           Ray{{-5, 5, 0}, {0, 1, 0}, true},         // side face
           Ray{{-5, -5, 0}, {0, 1, 0}, false},
           Ray{{-5, -5, 0}, {-1, -1, 0}, true},  // edge
           Ray{{-5, 1, 0}, {5, 1, 0}, true},     // along a face
           Ray{{0, 0, 0}, {-5, 0, 0}, false},    // from inside
           Ray{{-5, 0, 0}, {0, 0, 0}, false},    // inside
           // Walls.
           Ray{{-5, 5, 0}, {-10, 5, 0}, true},  // on the wall
           Ray{{-5, 5, 0}, {-10.1, 5, 0}, false},
           Ray{{-10.1, 5, 0}, {-5, 5, 0}, false},
       }) {
    EXPECT_EQ(world.visible(from, to), visible) << from.transpose() << " to " << to.transpose();
  }
}

}  // namespace
}  // namespace slim_init::simulation
