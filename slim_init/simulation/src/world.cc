// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/world.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "hull.h"
#include "random.h"

namespace slim_init::simulation {
namespace {

// [m] by which obstacles shrink and the hull grows in visibility tests, so that places computed on
// a surface count as in front of it.
constexpr double kSurfaceTolerance = 1e-6;

// What a kind of world looks like. Lengths in m.
struct Style {
  const char* kind;
  double relief;                       // depth of what stands before a wall
  int furniture;                       // boxes on the floor
  int pillars;                         // boxes from floor to ceiling
  double max_segment;                  // longest segment
  double free_share;                   // of the segments, not in a Manhattan direction
  std::array<double, 3> axis_weights;  // along, across, up: Manhattan directions on the walls
};
constexpr Style kStyles[] = {
    {"room", 0.8, 4, 2, 3.5, 0.30, {1.0, 1.0, 1.0}},
    {"hall", 0.8, 6, 4, 5.0, 0.30, {1.0, 1.0, 1.0}},
    // Mostly skirting boards, cable ducts and lamps along it, some door frames.
    {"corridor", 0.1, 0, 0, 6.0, 0.05, {6.0, 1.0, 2.0}},
};

constexpr double kMinSegment = 0.8;               // [m] before cutting at the surface's edge
constexpr double kMinCutSegment = 0.3;            // [m] after it
constexpr double kObstacleClearance = 0.7;        // [m] obstacle to path
constexpr double kObstacleGap = 0.4;              // [m] between obstacles
constexpr double kCorridorReferenceArea = 200.0;  // [m^2] of surface on 20 m of natural corridor
// Leaves some thirty trackable points in view with the default count: textureless.
constexpr double kCorridorPointShare = 0.0125;
constexpr int kMaxTries = 200;  // draws for one obstacle; of one point or segment: a tenth

// Whether the straight way between two places passes through the box.
bool crosses(const Box& box, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  double enter = 0.0;
  double leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min()[axis] + kSurfaceTolerance - from[axis];
    const double high = box.max()[axis] - kSurfaceTolerance - from[axis];
    const double step = to[axis] - from[axis];
    if (step == 0.0) {
      if (low > 0.0 || high < 0.0) return false;
      continue;
    }
    const double a = low / step;
    const double b = high / step;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

std::vector<Box> makeObstacles(const Style& style, const Box& hull,
                               const std::vector<Eigen::Vector3d>& path, unsigned seed) {
  Random random(seed, "world/obstacles");
  std::vector<Box> obstacles;
  const double height = hull.max().z() - hull.min().z();
  for (int i = 0; i < style.furniture + style.pillars; ++i) {
    const bool is_pillar = i < style.pillars;
    for (int attempt = 0; attempt < kMaxTries; ++attempt) {
      // Cupboards and tables of 0.6 to 1.6 m; pillars of 0.3 to 0.6 m.
      const double size_x = is_pillar ? random.uniform(0.3, 0.6) : random.uniform(0.6, 1.6);
      const double size_y = is_pillar ? random.uniform(0.3, 0.6) : random.uniform(0.6, 1.6);
      const double size_z = is_pillar ? height : random.uniform(0.3, 0.5) * height;
      Box box;
      box.min().x() = random.uniform(hull.min().x(), hull.max().x() - size_x);
      box.min().y() = random.uniform(hull.min().y(), hull.max().y() - size_y);
      box.min().z() = hull.min().z();
      box.max() = box.min() + Eigen::Vector3d(size_x, size_y, size_z);
      if (is_pillar) box.max().z() = hull.max().z();  // free of rounding
      const bool near_other =
          std::any_of(obstacles.begin(), obstacles.end(),
                      [&](const Box& other) { return grown(box, kObstacleGap).intersects(other); });
      if (near_other) continue;
      const bool near_path = std::any_of(path.begin(), path.end(), [&](const Eigen::Vector3d& p) {
        return p.allFinite() && box.exteriorDistance(p) < kObstacleClearance;
      });
      if (near_path) continue;
      obstacles.push_back(box);
      break;
    }
  }
  return obstacles;
}

// A rectangle of a wall or an obstacle: a box without thickness along `normal`.
struct Surface {
  Box rectangle;
  int normal = 0;       // axis
  double inward = 1.0;  // direction along `normal` into free space
  double relief = 0.0;  // [m]
  bool is_wall = true;
  double area = 0.0;  // [m^2]
};

Surface sideOf(const Box& box, int axis, bool upper) {
  Surface s;
  s.rectangle = box;
  s.rectangle.min()[axis] = s.rectangle.max()[axis] = upper ? box.max()[axis] : box.min()[axis];
  s.normal = axis;
  const Eigen::Vector3d size = box.max() - box.min();
  s.area = size[(axis + 1) % 3] * size[(axis + 2) % 3];
  return s;
}

bool onWall(const Surface& s, const Box& hull) {
  const double place = s.rectangle.min()[s.normal];
  return place <= hull.min()[s.normal] + kSurfaceTolerance ||
         place >= hull.max()[s.normal] - kSurfaceTolerance;
}

// All surfaces, chosen from in proportion to their area.
class Surfaces {
 public:
  Surfaces(const World& world, double wall_relief) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool upper : {false, true}) {
        Surface wall = sideOf(world.hull, axis, upper);
        wall.inward = upper ? -1.0 : 1.0;
        wall.relief = wall_relief;
        add(wall);
        for (const Box& obstacle : world.obstacles) {
          Surface face = sideOf(obstacle, axis, upper);
          face.inward = upper ? 1.0 : -1.0;
          face.is_wall = false;
          if (!onWall(face, world.hull)) add(face);
        }
      }
    }
  }

  const Surface& draw(Random* random) const {
    const double target = random->uniform() * cumulative_area_.back();
    const auto it = std::upper_bound(cumulative_area_.begin(), cumulative_area_.end(), target);
    const std::size_t i = std::min<std::size_t>(it - cumulative_area_.begin(), list_.size() - 1);
    return list_[i];
  }

 private:
  void add(const Surface& s) {
    cumulative_area_.push_back((list_.empty() ? 0.0 : cumulative_area_.back()) + s.area);
    list_.push_back(s);
  }

  std::vector<Surface> list_;
  std::vector<double> cumulative_area_;
};

// A place on the surface; half of those on a wall stand out from it.
Eigen::Vector3d drawPlace(const Surface& s, Random* random) {
  Eigen::Vector3d p;
  for (int axis = 0; axis < 3; ++axis) {
    p[axis] = random->uniform(s.rectangle.min()[axis], s.rectangle.max()[axis]);
  }
  const bool stands_out = random->uniform() < 0.5;
  const double depth = s.relief * random->uniform();
  p[s.normal] = s.rectangle.min()[s.normal] + (stands_out ? s.inward * depth : 0.0);
  return p;
}

bool insideObstacle(const World& world, const Eigen::Vector3d& p) {
  return std::any_of(world.obstacles.begin(), world.obstacles.end(),
                     [&](const Box& box) { return grown(box, kSurfaceTolerance).contains(p); });
}

void addPoints(const Style& style, int count, unsigned seed, World* world) {
  Random random(seed, "world/points");
  const Surfaces surfaces(*world, style.relief);
  world->points.reserve(count);
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d p;
    for (int attempt = 0; attempt < kMaxTries / 10; ++attempt) {
      const Surface& s = surfaces.draw(&random);
      p = drawPlace(s, &random);
      if (!s.is_wall || !insideObstacle(*world, p)) break;
    }
    world->points.push_back(p);
  }
}

// The edges of obstacles that can be seen: four upright ones and, below the ceiling, four on top.
std::vector<Segment> obstacleEdges(const World& world) {
  std::vector<Segment> edges;
  for (const Box& b : world.obstacles) {
    const double x[2] = {b.min().x(), b.max().x()};
    const double y[2] = {b.min().y(), b.max().y()};
    const double top = b.max().z();
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) edges.push_back({{x[i], y[j], b.min().z()}, {x[i], y[j], top}});
    }
    if (top >= world.hull.max().z() - kSurfaceTolerance) continue;
    for (int i = 0; i < 2; ++i) {
      edges.push_back({{x[0], y[i], top}, {x[1], y[i], top}});
      edges.push_back({{x[i], y[0], top}, {x[i], y[1], top}});
    }
  }
  return edges;
}

// A Manhattan axis within a surface, drawn by weight.
int drawAxis(const std::array<double, 3>& weights, int normal, Random* random) {
  const int a = (normal + 1) % 3;
  const int b = (normal + 2) % 3;
  return random->uniform() * (weights[a] + weights[b]) < weights[a] ? a : b;
}

// Cuts a segment through `center` at the surface's edges.
Segment cutToSurface(const Surface& s, const Eigen::Vector3d& center,
                     const Eigen::Vector3d& direction, double length) {
  double back = -0.5 * length;
  double ahead = 0.5 * length;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == s.normal || direction[axis] == 0.0) continue;
    const double a = (s.rectangle.min()[axis] - center[axis]) / direction[axis];
    const double b = (s.rectangle.max()[axis] - center[axis]) / direction[axis];
    back = std::max(back, std::min(a, b));
    ahead = std::min(ahead, std::max(a, b));
  }
  Segment segment{center + back * direction, center + ahead * direction};
  for (Eigen::Vector3d* end : {&segment.start, &segment.end}) {
    for (int axis = 0; axis < 3; ++axis) {  // against rounding
      if (axis == s.normal) continue;
      (*end)[axis] = std::clamp((*end)[axis], s.rectangle.min()[axis], s.rectangle.max()[axis]);
    }
  }
  return segment;
}

void addSegments(const Style& style, const std::array<double, 3>& axis_weights, int count,
                 unsigned seed, World* world) {
  Random random(seed, "world/segments");
  const Surfaces surfaces(*world, style.relief);
  world->segments = obstacleEdges(*world);
  // Few segments asked for: half of them at most are edges of obstacles.
  if (static_cast<int>(world->segments.size()) > count / 2) world->segments.resize(count / 2);
  const int free_end = static_cast<int>(world->segments.size()) +
                       static_cast<int>(std::lround(style.free_share * count));
  world->segments.reserve(count);
  while (static_cast<int>(world->segments.size()) < count) {
    const bool is_free = static_cast<int>(world->segments.size()) < free_end;
    Segment segment;
    for (int attempt = 0; attempt < kMaxTries / 10; ++attempt) {
      const Surface& s = surfaces.draw(&random);
      const Eigen::Vector3d center = drawPlace(s, &random);
      const double length = random.uniform(kMinSegment, style.max_segment);
      Eigen::Vector3d direction = Eigen::Vector3d::Zero();
      if (is_free) {
        const double angle = random.uniform(0.0, M_PI);
        direction[(s.normal + 1) % 3] = std::cos(angle);
        direction[(s.normal + 2) % 3] = std::sin(angle);
      } else {
        direction[drawAxis(axis_weights, s.normal, &random)] = 1.0;
      }
      segment = cutToSurface(s, center, direction, length);
      const bool hidden = s.is_wall && insideObstacle(*world, center);
      if (!hidden && (segment.end - segment.start).norm() >= kMinCutSegment) break;
    }
    world->segments.push_back(segment);
  }
}

}  // namespace

bool World::visible(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  // The hull is convex: between two places inside it there is no wall.
  const Box inside = grown(hull, kSurfaceTolerance);
  if (!inside.contains(from) || !inside.contains(to)) return false;
  return std::none_of(obstacles.begin(), obstacles.end(),
                      [&](const Box& box) { return crosses(box, from, to); });
}

const std::vector<std::string>& worldNames() {
  static const std::vector<std::string> names = {"room", "hall", "corridor"};
  return names;
}

World makeWorld(const WorldOptions& options, const std::vector<Eigen::Vector3d>& path_w) {
  const Style& style = *std::find_if(std::begin(kStyles), std::end(kStyles) - 1,
                                     [&](const Style& s) { return options.kind == s.kind; });
  const bool corridor = options.kind == "corridor";
  const Box path = boundsOf(path_w);

  World world;
  world.hull = makeHull(options.kind, path);
  world.obstacles = makeObstacles(style, world.hull, path_w, options.seed);

  double points = std::max(0, options.points);
  double segments = std::max(0, options.segments);
  std::array<double, 3> axis_weights = style.axis_weights;
  if (corridor) {
    const int along = longAxis(path);
    if (along == 1) std::swap(axis_weights[0], axis_weights[1]);
    // By area, so that neither the length of the path nor a hull grown wide changes the density.
    const Eigen::Vector3d size = world.hull.max() - world.hull.min();
    const double area = 2.0 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
    points *= kCorridorPointShare * area / kCorridorReferenceArea;
    segments *= area / kCorridorReferenceArea;
  }
  addPoints(style, static_cast<int>(std::lround(points)), options.seed, &world);
  addSegments(style, axis_weights, static_cast<int>(std::lround(segments)), options.seed, &world);
  return world;
}

}  // namespace slim_init::simulation
