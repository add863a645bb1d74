// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "hull.h"
#include "random.h"
#include "slim_init/simulation/scene.h"

namespace slim_init::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWallThickness = 0.2;       // [m]
constexpr double kFurnitureClearance = 0.7;  // [m] to the path
constexpr double kGap = 0.1;                 // [m] between things on a wall or a floor
constexpr double kEmbed = 0.01;              // [m] what hangs on a wall reaches into it
constexpr int kMaxTries = 60;                // draws for the place of one thing

Look plain(double bright) { return {Pattern::kPlain, bright, bright, 1.0, 0.0, 0.0}; }
Look glowing(double glow) { return {Pattern::kPlain, 0.3, 0.3, 1.0, 0.0, glow}; }

// An upright wall, seen from inside.
struct Wall {
  int normal = 0;       // axis
  double place = 0.0;   // coordinate of its surface along `normal`
  double inward = 1.0;  // direction along `normal` into the room
  double low = 0.0;     // extent along the other horizontal axis
  double high = 0.0;
  std::vector<Box> taken;  // by what hangs there: u, z, unused

  int across() const { return 1 - normal; }
  double width() const { return high - low; }
};

// Puts things into a scene, and knows the path that has to stay free.
class Builder {
 public:
  Builder(Scene* scene, const std::vector<Vector3d>& path_w, unsigned seed)
      : random(seed, "scene"), scene_(scene) {
    // Every few centimetres is enough, and keeps the checks cheap.
    constexpr double kStep = 0.03;  // [m]
    for (const Vector3d& p : path_w) {
      if (!p.allFinite()) continue;
      if (path_.empty() || (p - path_.back()).norm() >= kStep) path_.push_back(p);
    }
    const Box& hull = scene->hull;
    for (int normal = 0; normal < 2; ++normal) {
      for (const bool upper : {false, true}) {
        Wall wall;
        wall.normal = normal;
        wall.place = upper ? hull.max[normal] : hull.min[normal];
        wall.inward = upper ? -1.0 : 1.0;
        wall.low = hull.min[1 - normal];
        wall.high = hull.max[1 - normal];
        walls.push_back(wall);
      }
    }
  }

  Random random;
  std::vector<Wall> walls;

  double floor() const { return scene_->hull.min.z(); }
  double ceiling() const { return scene_->hull.max.z(); }

  int look(const Look& look) {
    scene_->looks.push_back(look);
    return static_cast<int>(scene_->looks.size()) - 1;
  }

  void box(const std::string& name, const Vector3d& min, const Vector3d& max, int look,
           double yaw_deg = 0.0) {
    Solid solid;
    solid.name = name;
    solid.center = 0.5 * (min + max);
    solid.half_size = 0.5 * (max - min);
    solid.yaw_deg = yaw_deg;
    solid.look = look;
    scene_->solids.push_back(solid);
  }

  void cylinder(const std::string& name, const Vector3d& min, const Vector3d& max, int axis,
                int look) {
    box(name, min, max, look);
    scene_->solids.back().shape = Shape::kCylinder;
    scene_->solids.back().axis = axis;
  }

  // Floor, ceiling and four walls; the looks of walls are drawn anew for each of them, because
  // patterns that meet in a corner do not continue around it.
  void shell(const Look& floor_look, const Look& ceiling_look, const Look& wall_look) {
    const Box& h = scene_->hull;
    const Vector3d t = Vector3d::Constant(kWallThickness);
    box("floor", {h.min.x() - t.x(), h.min.y() - t.y(), h.min.z() - t.z()},
        {h.max.x() + t.x(), h.max.y() + t.y(), h.min.z()}, look(floor_look));
    box("ceiling", {h.min.x() - t.x(), h.min.y() - t.y(), h.max.z()},
        {h.max.x() + t.x(), h.max.y() + t.y(), h.max.z() + t.z()}, look(ceiling_look));
    for (const Wall& wall : walls) {
      Vector3d min, max;
      min[wall.normal] = wall.inward > 0 ? wall.place - kWallThickness : wall.place;
      max[wall.normal] = wall.inward > 0 ? wall.place : wall.place + kWallThickness;
      min[wall.across()] = wall.low;
      max[wall.across()] = wall.high;
      min.z() = h.min.z();
      max.z() = h.max.z();
      box("wall", min, max, look(wall_look));
    }
  }

  // Corners of what stands out of a wall from `back` to `front` metres.
  Box wallBox(const Wall& wall, double u0, double u1, double z0, double z1, double back,
              double front) const {
    Box b;
    const double a = wall.place + wall.inward * back;
    const double c = wall.place + wall.inward * front;
    b.min[wall.normal] = std::min(a, c);
    b.max[wall.normal] = std::max(a, c);
    b.min[wall.across()] = u0;
    b.max[wall.across()] = u1;
    b.min.z() = z0;
    b.max.z() = z1;
    return b;
  }
  void onWall(const std::string& name, const Wall& wall, double u0, double u1, double z0, double z1,
              double depth, int look) {
    const Box b = wallBox(wall, u0, u1, z0, z1, -kEmbed, depth);
    box(name, b.min, b.max, look);
  }

  // Whether a part of a wall is free; takes it when it is.
  bool take(Wall* wall, double u0, double u1, double z0, double z1) {
    if (u0 < wall->low + kGap || u1 > wall->high - kGap || z0 < floor() || z1 > ceiling()) {
      return false;
    }
    for (const Box& b : wall->taken) {
      if (u0 < b.max.x() + kGap && b.min.x() < u1 + kGap && z0 < b.max.y() + kGap &&
          b.min.y() < z1 + kGap) {
        return false;
      }
    }
    wall->taken.push_back({{u0, z0, 0.0}, {u1, z1, 0.0}});
    return true;
  }

  bool clearOfPath(const Box& b, double clearance) const {
    return std::none_of(path_.begin(), path_.end(), [&](const Vector3d& p) {
      return (p - p.cwiseMax(b.min).cwiseMin(b.max)).squaredNorm() < clearance * clearance;
    });
  }

  // A free place on the floor for a thing of this size; with `near_walls` along the walls first.
  bool standing(const Vector3d& size, bool near_walls, Box* place) {
    const Box& h = scene_->hull;
    for (int attempt = 0; attempt < kMaxTries; ++attempt) {
      Box b;
      for (int axis = 0; axis < 2; ++axis) {
        const double room = h.max[axis] - h.min[axis] - size[axis] - 2.0 * kGap;
        if (room < 0.0) return false;
        b.min[axis] = h.min[axis] + kGap + random.uniform() * room;
      }
      if (near_walls && attempt < kMaxTries / 2) {
        const int axis = random.index(2);
        b.min[axis] = random.uniform() < 0.5 ? h.min[axis] + kGap : h.max[axis] - kGap - size[axis];
      }
      b.min.z() = h.min.z();
      b.max = b.min + size;
      const bool collides = std::any_of(standing_.begin(), standing_.end(), [&](const Box& o) {
        return b.min.x() < o.max.x() + kGap && o.min.x() < b.max.x() + kGap &&
               b.min.y() < o.max.y() + kGap && o.min.y() < b.max.y() + kGap;
      });
      if (collides || !clearOfPath(b, kFurnitureClearance)) continue;
      standing_.push_back(b);
      *place = b;
      return true;
    }
    return false;
  }

  void light(const Vector3d& position, double brightness, double reach) {
    scene_->lights.push_back({position, brightness, reach});
  }

 private:
  Scene* scene_;
  std::vector<Vector3d> path_;
  std::vector<Box> standing_;  // what stands on the floor
};

// --- Things on walls -----------------------------------------------------------------------------

// The pattern of a poster or picture.
Look posterLook(Random* random) {
  Look look;
  look.dark = random->uniform(0.05, 0.2);
  look.bright = random->uniform(0.5, 0.9);
  switch (random->index(5)) {
    case 0:
      look.pattern = Pattern::kMosaic;
      look.size_m = random->uniform(0.05, 0.18);
      break;
    case 1:
      look.pattern = Pattern::kMosaic;
      look.size_m = random->uniform(0.12, 0.3);
      break;
    case 2:
      look.pattern = Pattern::kGranite;
      look.size_m = random->uniform(0.4, 1.0);
      break;
    case 3:
      look.pattern = Pattern::kChecker;
      look.size_m = random->uniform(0.08, 0.2);
      look.angle_deg = random->uniform(0.0, 90.0);
      break;
    default:
      look.pattern = Pattern::kStripes;
      look.size_m = random->uniform(0.06, 0.2);
      look.angle_deg = random->uniform(0.0, 180.0);
      break;
  }
  return look;
}

void addPoster(Builder* b, Wall* wall) {
  Random& random = b->random;
  for (int attempt = 0; attempt < kMaxTries; ++attempt) {
    const double w = random.uniform(0.5, 1.4);
    const double h = random.uniform(0.5, 1.3);
    const double u = random.uniform(wall->low, wall->high - w);
    const double z = random.uniform(b->floor() + 0.5, b->ceiling() - 0.2 - h);
    if (!b->take(wall, u, u + w, z, z + h)) continue;
    const bool framed = random.uniform() < 0.6;
    if (framed) {
      const double rim = random.uniform(0.02, 0.05);
      const int frame = b->look(plain(random.uniform() < 0.5 ? 0.12 : 0.8));
      b->onWall("frame", *wall, u, u + w, z, z + h, 0.015, frame);
      b->onWall("picture", *wall, u + rim, u + w - rim, z + rim, z + h - rim, 0.018,
                b->look(posterLook(&random)));
      return;
    }
    if (random.uniform() < 0.5) {
      b->onWall("poster", *wall, u, u + w, z, z + h, 0.003, b->look(posterLook(&random)));
      return;
    }
    // A printed sheet: a pale ground, a heading, blocks of grey.
    b->onWall("sheet", *wall, u, u + w, z, z + h, 0.003, b->look(plain(0.85)));
    double top = z + h - 0.05;
    while (top - z > 0.15) {
      const double row = random.uniform(0.04, 0.22);
      double left = u + 0.05;
      while (u + w - left > 0.15) {
        const double column = std::min(random.uniform(0.1, 0.5), u + w - 0.05 - left);
        const double bottom = std::max(z + 0.05, top - row);
        const double grey = random.uniform(0.08, 0.6);
        b->onWall("print", *wall, left, left + column, bottom, top, 0.005,
                  b->look(random.uniform() < 0.3
                              ? Look{Pattern::kMosaic, grey + 0.2, 0.05, 0.06, 0.0, 0.0}
                              : plain(grey)));
        left += column + random.uniform(0.03, 0.08);
      }
      top -= row + random.uniform(0.03, 0.06);
    }
    return;
  }
}

// Frame, leaf, handle and sign of a door whose left post is at u; 1 m wide, 2.1 m high.
void addDoorAt(Builder* b, const Wall& wall, double u, double leaf_brightness, bool sign) {
  const double z = b->floor();
  const int frame = b->look(plain(0.18));
  const int leaf = b->look(plain(leaf_brightness));
  const int metal = b->look(plain(0.75));
  const int dark = b->look(plain(0.08));
  b->onWall("door post", wall, u, u + 0.07, z, z + 2.1, 0.035, frame);
  b->onWall("door post", wall, u + 0.93, u + 1.0, z, z + 2.1, 0.035, frame);
  b->onWall("lintel", wall, u, u + 1.0, z + 2.1, z + 2.17, 0.035, frame);
  b->onWall("door leaf", wall, u + 0.07, u + 0.93, z + 0.01, z + 2.1, 0.012, leaf);
  b->onWall("handle plate", wall, u + 0.83, u + 0.88, z + 0.92, z + 1.14, 0.018, metal);
  b->onWall("handle", wall, u + 0.73, u + 0.87, z + 1.04, z + 1.07, 0.06, dark);
  if (sign) {
    const double v = u - 0.3;
    b->onWall("sign", wall, v, v + 0.2, z + 1.55, z + 1.7, 0.008, b->look(plain(0.9)));
    Random& random = b->random;
    for (int i = 0; i < 3; ++i) {
      const double g = v + 0.03 + 0.05 * i;
      b->onWall("sign print", wall, g, g + random.uniform(0.015, 0.04), z + 1.6,
                z + random.uniform(1.63, 1.67), 0.0095, dark);
    }
  }
}

void addDoor(Builder* b, Wall* wall) {
  for (int attempt = 0; attempt < kMaxTries; ++attempt) {
    const double u = b->random.uniform(wall->low, wall->high - 1.0);
    if (!b->take(wall, u, u + 1.0, b->floor(), b->floor() + 2.2)) continue;
    addDoorAt(b, *wall, u, 0.35, false);
    return;
  }
}

void addWindow(Builder* b, Wall* wall, double w, double h, double sill) {
  for (int attempt = 0; attempt < kMaxTries; ++attempt) {
    const double u = b->random.uniform(wall->low, wall->high - w);
    const double z = b->floor() + sill;
    if (!b->take(wall, u, u + w, z, z + h)) continue;
    const int frame = b->look(plain(0.8));
    b->onWall("window frame", *wall, u, u + w, z, z + h, 0.03, frame);
    const int pane = b->look(glowing(0.55));
    const double rim = 0.06;
    const double half_u = 0.5 * w;
    for (int i = 0; i < 2; ++i) {
      const double a = u + i * half_u + (i == 0 ? rim : 0.5 * rim);
      const double c = u + (i + 1) * half_u - (i == 0 ? 0.5 * rim : rim);
      b->onWall("pane", *wall, a, c, z + rim, z + h - rim, 0.032, pane);
    }
    b->onWall("window sill", *wall, u - 0.05, u + w + 0.05, z - 0.04, z, 0.12, frame);
    return;
  }
}

// A radiator: upright ribs between two rails.
void addRadiator(Builder* b, Wall* wall) {
  for (int attempt = 0; attempt < kMaxTries; ++attempt) {
    const double w = 1.0;
    const double u = b->random.uniform(wall->low, wall->high - w);
    const double z = b->floor() + 0.12;
    if (!b->take(wall, u, u + w, z, z + 0.6)) continue;
    const int look = b->look(plain(0.72));
    for (int i = 0; i < 10; ++i) {
      const double a = u + 0.1 * i;
      const Box rib = b->wallBox(*wall, a, a + 0.06, z, z + 0.6, 0.03, 0.11);
      b->box("rib", rib.min, rib.max, look);
    }
    const Box rail = b->wallBox(*wall, u, u + w, z + 0.05, z + 0.1, 0.04, 0.1);
    b->box("rail", rail.min, rail.max, look);
    return;
  }
}

void addSkirting(Builder* b, double height, double brightness) {
  const int look = b->look(plain(brightness));
  for (const Wall& wall : b->walls) {
    b->onWall("skirting", wall, wall.low, wall.high, b->floor(), b->floor() + height, 0.015, look);
  }
}

// --- Things on the floor -------------------------------------------------------------------------

void addCupboard(Builder* b, bool textured) {
  Random& random = b->random;
  const Vector3d size(random.uniform(0.8, 1.5), random.uniform(0.4, 0.7), random.uniform(0.8, 1.9));
  const bool turned = random.uniform() < 0.5;
  Box place;
  const Vector3d turned_size(size.y(), size.x(), size.z());
  if (!b->standing(turned ? turned_size : size, true, &place)) return;
  Look body{Pattern::kPlanks, random.uniform(0.4, 0.6), random.uniform(0.2, 0.35), 0.15, 0.0, 0.0};
  if (!textured) body = plain(random.uniform(0.3, 0.6));
  b->box("cupboard", place.min, place.max, b->look(body));
  // Doors stand 1 cm proud on all four long sides, so that whichever is seen has them.
  const int axis = turned ? 1 : 0;
  const int door = b->look(plain(random.uniform(0.25, 0.65)));
  const int knob = b->look(plain(0.1));
  const double half = 0.5 * (place.max[axis] - place.min[axis]);
  for (int i = 0; i < 2; ++i) {
    Vector3d min = place.min;
    Vector3d max = place.max;
    min[1 - axis] -= 0.01;
    max[1 - axis] += 0.01;
    min[axis] = place.min[axis] + i * half + 0.03;
    max[axis] = place.min[axis] + (i + 1) * half - 0.03;
    min.z() += 0.08;
    max.z() -= 0.05;
    b->box("cupboard door", min, max, door);
    const double u = i == 0 ? max[axis] - 0.06 : min[axis] + 0.03;
    Vector3d kmin = min;
    Vector3d kmax = max;
    kmin[axis] = u;
    kmax[axis] = u + 0.03;
    kmin[1 - axis] -= 0.02;
    kmax[1 - axis] += 0.02;
    kmin.z() = 0.5 * (min.z() + max.z()) - 0.08;
    kmax.z() = kmin.z() + 0.16;
    b->box("knob", kmin, kmax, knob);
  }
}

void addTable(Builder* b, bool textured) {
  Random& random = b->random;
  const Vector3d size(random.uniform(1.0, 1.6), random.uniform(0.6, 0.9), 0.74);
  Box place;
  if (!b->standing(size, false, &place)) return;
  Look top{Pattern::kPlanks, 0.55, 0.35, 0.12, 0.0, 0.0};
  if (!textured) top = plain(0.5);
  b->box("table top", {place.min.x(), place.min.y(), place.max.z() - 0.04}, place.max,
         b->look(top));
  const int leg = b->look(plain(0.15));
  for (int i = 0; i < 4; ++i) {
    const double x = i % 2 == 0 ? place.min.x() + 0.03 : place.max.x() - 0.08;
    const double y = i / 2 == 0 ? place.min.y() + 0.03 : place.max.y() - 0.08;
    b->box("table leg", {x, y, place.min.z()}, {x + 0.05, y + 0.05, place.max.z() - 0.04}, leg);
  }
  // Books and boxes on it.
  const int things = 2 + random.index(3);
  for (int i = 0; i < things; ++i) {
    const double x = random.uniform(place.min.x() + 0.2, place.max.x() - 0.2);
    const double y = random.uniform(place.min.y() + 0.2, place.max.y() - 0.2);
    const Vector3d half(random.uniform(0.06, 0.16), random.uniform(0.05, 0.12),
                        random.uniform(0.03, 0.18));
    const Vector3d center(x, y, place.max.z() + half.z());
    b->box("thing", center - half, center + half,
           b->look(textured ? posterLook(&random) : plain(random.uniform(0.15, 0.7))),
           random.uniform(-60.0, 60.0));
  }
}

void addCrates(Builder* b, bool textured, double scale) {
  Random& random = b->random;
  const double s = scale * random.uniform(0.4, 0.8);
  Box place;
  // Room for the turned crate: its diagonal.
  const double room = 1.42 * s;
  if (!b->standing({room, room, 1.7 * s}, false, &place)) return;
  const Vector3d foot(0.5 * (place.min.x() + place.max.x()), 0.5 * (place.min.y() + place.max.y()),
                      place.min.z());
  const auto crate = [&](double size, double base) {
    const double yaw = random.uniform(-45.0, 45.0);
    const Vector3d half(0.5 * size, 0.5 * size, 0.5 * size);
    const Vector3d center = foot + Vector3d(0.0, 0.0, base + half.z());
    Look body{Pattern::kPlanks,          random.uniform(0.45, 0.65),
              random.uniform(0.2, 0.35), 0.12,
              90.0 * random.index(2),    0.0};
    if (!textured) body = plain(random.uniform(0.25, 0.7));
    b->box("crate", center - half, center + half, b->look(body), yaw);
    // Battens around it.
    const int batten = b->look(plain(textured ? 0.25 : 0.5));
    for (const double z : {-0.38, 0.38}) {
      const Vector3d rim(1.06 * half.x(), 1.06 * half.y(), 0.06 * size);
      const Vector3d at = center + Vector3d(0.0, 0.0, z * size);
      b->box("batten", at - rim, at + rim, batten, yaw);
    }
  };
  crate(s, 0.0);
  if (random.uniform() < 0.6) crate(0.7 * s, s);
}

// A machine: a body with panels, feet, a motor and a pipe that goes up.
void addMachine(Builder* b) {
  Random& random = b->random;
  const Vector3d size(random.uniform(1.2, 3.5), random.uniform(1.0, 2.2), random.uniform(1.2, 3.0));
  const bool turned = random.uniform() < 0.5;
  Box place;
  const Vector3d turned_size(size.y(), size.x(), size.z());
  if (!b->standing(turned ? turned_size : size, random.uniform() < 0.5, &place)) return;
  const Vector3d extent = place.max - place.min;
  Vector3d top = place.max;
  top.z() -= 0.25 * extent.z();
  Look body{Pattern::kGranite, random.uniform(0.35, 0.6), random.uniform(0.2, 0.3), 1.5, 0.0, 0.0};
  b->box("machine base", place.min, {top.x(), top.y(), place.min.z() + 0.15}, b->look(plain(0.12)));
  b->box("machine", {place.min.x() + 0.05, place.min.y() + 0.05, place.min.z() + 0.15},
         {top.x() - 0.05, top.y() - 0.05, top.z()}, b->look(body));
  // Panels on all four sides.
  for (int side = 0; side < 4; ++side) {
    const int normal = side / 2;
    const int across = 1 - normal;
    const double place_n = side % 2 == 0 ? place.min[normal] + 0.05 : place.max[normal] - 0.05;
    double u = place.min[across] + 0.15;
    while (place.max[across] - u > 0.5) {
      const double w = std::min(random.uniform(0.35, 0.9), place.max[across] - 0.15 - u);
      const double z0 = random.uniform(place.min.z() + 0.3, place.min.z() + 0.5);
      const double z1 = std::min(top.z() - 0.1, z0 + random.uniform(0.4, 1.5));
      if (w > 0.2 && z1 - z0 > 0.2) {
        Vector3d min, max;
        min[normal] = place_n - 0.02;
        max[normal] = place_n + 0.02;
        min[across] = u;
        max[across] = u + w;
        min.z() = z0;
        max.z() = z1;
        Look panel;
        switch (random.index(5)) {
          case 0: panel = {Pattern::kStripes, 0.6, 0.1, 0.05, 90.0 * random.index(2), 0.0}; break;
          case 1: panel = {Pattern::kMosaic, 0.75, 0.1, random.uniform(0.06, 0.2), 0.0, 0.0}; break;
          case 2: panel = {Pattern::kChecker, 0.5, 0.2, 0.08, 0.0, 0.0}; break;
          default: panel = plain(random.uniform(0.1, 0.75)); break;
        }
        b->box("panel", min, max, b->look(panel));
        // Dials and bolts.
        const int dial = b->look(plain(random.uniform() < 0.5 ? 0.85 : 0.05));
        for (int i = 0; i < 3; ++i) {
          const double a = random.uniform(u + 0.03, u + w - 0.1);
          const double z = random.uniform(z0 + 0.03, z1 - 0.1);
          Vector3d dmin = min;
          Vector3d dmax = max;
          dmin[normal] -= 0.012;
          dmax[normal] += 0.012;
          dmin[across] = a;
          dmax[across] = a + random.uniform(0.03, 0.07);
          dmin.z() = z;
          dmax.z() = z + random.uniform(0.03, 0.07);
          b->box("dial", dmin, dmax, dial);
        }
      }
      u += w + random.uniform(0.08, 0.3);
    }
  }
  // A motor on top and a pipe to the ceiling.
  const Vector3d motor(random.uniform(place.min.x() + 0.2, place.max.x() - 0.7),
                       random.uniform(place.min.y() + 0.2, place.max.y() - 0.7), top.z());
  b->box("motor", motor, {motor.x() + 0.5, motor.y() + 0.4, place.max.z()},
         b->look({Pattern::kStripes, 0.45, 0.15, 0.04, 0.0, 0.0}));
  const double r = random.uniform(0.05, 0.12);
  const Vector3d foot(place.min.x() + 0.1 + r, place.min.y() + 0.1 + r, top.z());
  const Box pipe{{foot.x() - r, foot.y() - r, foot.z()},
                 {foot.x() + r, foot.y() + r, b->ceiling()}};
  if (b->clearOfPath(pipe, kFurnitureClearance)) {
    b->cylinder("pipe", pipe.min, pipe.max, 2, b->look(plain(random.uniform(0.3, 0.7))));
  }
}

// --- Rooms ---------------------------------------------------------------------------------------

// Square lamps in a grid under the ceiling. Four lights stand for them all: every light has to be
// summed up for every pixel.
void addLampGrid(Builder* b, const Box& hull, double spacing, double size, double brightness,
                 double reach) {
  const int lamp = b->look(glowing(0.95));
  const int rim = b->look(plain(0.5));
  const Vector3d extent = hull.max - hull.min;
  const auto grid = [&](int nx, int ny, const auto& place) {
    for (int i = 0; i < nx; ++i) {
      for (int j = 0; j < ny; ++j) {
        place(Vector3d(hull.min.x() + (i + 0.5) * extent.x() / nx,
                       hull.min.y() + (j + 0.5) * extent.y() / ny, hull.max.z()));
      }
    }
  };
  const int nx = std::max(1, static_cast<int>(std::lround(extent.x() / spacing)));
  const int ny = std::max(1, static_cast<int>(std::lround(extent.y() / spacing)));
  grid(nx, ny, [&](const Vector3d& c) {
    const Vector3d h(0.5 * size, 0.5 * size, 0.0);
    b->box("lamp rim", c - h - Vector3d(0.04, 0.04, 0.06), c + h + Vector3d(0.04, 0.04, 0.01), rim);
    b->box("lamp", c - h - Vector3d(0.0, 0.0, 0.065), c + h, lamp);
  });
  grid(2, 2, [&](const Vector3d& c) { b->light(c - Vector3d(0.0, 0.0, 0.3), brightness, reach); });
}

void buildRoom(const std::string& kind, Builder* b, Scene* scene) {
  Random& random = b->random;
  const bool blank = kind == "blank-room";
  const bool bricks = kind == "brick-room";
  const bool tiles = kind == "tile-room";
  Look wall{Pattern::kPlaster, 0.62, 0.55, 0.6, 0.0, 0.0};
  Look floor{Pattern::kPlanks, 0.5, 0.3, 0.14, 0.0, 0.0};
  Look ceiling{Pattern::kTiles, 0.7, 0.4, 0.6, 0.0, 0.0};
  if (bricks) {
    wall = {Pattern::kBricks, 0.42, 0.68, 0.25, 0.0, 0.0};
    floor = {Pattern::kTiles, 0.45, 0.3, 0.4, 0.0, 0.0};
  } else if (tiles) {
    wall = {Pattern::kTiles, 0.7, 0.3, 0.15, 0.0, 0.0};
    floor = {Pattern::kChecker, 0.6, 0.25, 0.3, 0.0, 0.0};
  } else if (blank) {
    wall = plain(0.6);
    floor = plain(0.35);
    ceiling = plain(0.75);
  }
  b->shell(floor, ceiling, wall);
  addLampGrid(b, scene->hull, 4.0, 0.6, 0.4, 3.0);
  addSkirting(b, 0.09, 0.2);
  addDoor(b, &b->walls[random.index(4)]);
  addWindow(b, &b->walls[random.index(4)], 1.8, 1.2, 1.0);
  addWindow(b, &b->walls[random.index(4)], 1.2, 1.2, 1.0);
  addRadiator(b, &b->walls[random.index(4)]);
  const int posters = kind == "room" ? 22 : blank ? 2 : 6;
  for (int i = 0; i < posters; ++i) addPoster(b, &b->walls[i % 4]);
  for (int i = 0; i < 3; ++i) addCupboard(b, !blank);
  for (int i = 0; i < 2; ++i) addTable(b, !blank);
  for (int i = 0; i < 4; ++i) addCrates(b, !blank, 1.0);
}

// Upright girders along a wall, an H of three boxes each, and a beam under the ceiling to the wall
// on the other side.
void addGirders(Builder* b, const Box& hull) {
  const int steel = b->look({Pattern::kPlaster, 0.42, 0.3, 0.4, 0.0, 0.0});
  constexpr double kSpacing = 3.5;
  for (const Wall& wall : b->walls) {
    const int count = std::max(1, static_cast<int>(wall.width() / kSpacing));
    for (int i = 0; i < count; ++i) {
      const double u = wall.low + (i + 0.5) * wall.width() / count;
      const auto part = [&](double u0, double u1, double back, double front) {
        const Box p = b->wallBox(wall, u0, u1, b->floor(), b->ceiling(), back, front);
        if (b->clearOfPath(p, 0.5)) b->box("girder", p.min, p.max, steel);
      };
      part(u - 0.15, u + 0.15, -kEmbed, 0.03);
      part(u - 0.02, u + 0.02, 0.03, 0.27);
      part(u - 0.15, u + 0.15, 0.27, 0.30);
      if (wall.normal != 1 || wall.inward < 0) continue;
      Vector3d min(u - 0.12, hull.min.y(), b->ceiling() - 0.45);
      Vector3d max(u + 0.12, hull.max.y(), b->ceiling() - 0.15);
      if (b->clearOfPath({min, max}, kFurnitureClearance)) b->box("beam", min, max, steel);
    }
  }
}

// Pipes along the walls with clamps.
void addPipes(Builder* b) {
  Random& random = b->random;
  for (const Wall& wall : b->walls) {
    for (int i = 0; i < 2; ++i) {
      const double r = random.uniform(0.04, 0.1);
      const double z = random.uniform(b->floor() + 2.6, b->ceiling() - 0.8);
      const int look = b->look(plain(random.uniform(0.2, 0.75)));
      const Box pipe = b->wallBox(wall, wall.low, wall.high, z - r, z + r, 0.34, 0.34 + 2.0 * r);
      if (!b->clearOfPath(pipe, 0.5)) continue;
      b->cylinder("pipe", pipe.min, pipe.max, wall.across(), look);
      const int clamp = b->look(plain(0.15));
      for (double u = wall.low + 1.0; u < wall.high - 1.0; u += 2.0) {
        const Box c = b->wallBox(wall, u, u + 0.06, z - 1.3 * r, z + 1.3 * r, 0.0, 0.36 + 2.0 * r);
        b->box("clamp", c.min, c.max, clamp);
      }
    }
  }
}

// A gallery with a railing along one wall.
void addGallery(Builder* b, const Wall& wall, double height) {
  const double z = b->floor() + height;
  const Box slab = b->wallBox(wall, wall.low, wall.high, z - 0.12, z, 0.0, 1.2);
  const Box whole = b->wallBox(wall, wall.low, wall.high, z - 0.12, z + 1.1, 0.0, 1.2);
  if (!b->clearOfPath(whole, kFurnitureClearance)) return;
  b->box("gallery", slab.min, slab.max, b->look({Pattern::kChecker, 0.4, 0.3, 0.05, 0.0, 0.0}));
  const int rail = b->look(plain(0.65));
  for (const double h : {0.5, 1.0}) {
    const Box r = b->wallBox(wall, wall.low, wall.high, z + h, z + h + 0.04, 1.14, 1.18);
    b->box("rail", r.min, r.max, rail);
  }
  for (double u = wall.low + 0.5; u < wall.high; u += 1.5) {
    const Box p = b->wallBox(wall, u, u + 0.04, z, z + 1.0, 1.14, 1.18);
    b->box("post", p.min, p.max, rail);
  }
}

void buildHall(Builder* b, Scene* scene) {
  Random& random = b->random;
  b->shell({Pattern::kGranite, 0.45, 0.3, 2.0, 0.0, 0.0},
           {Pattern::kStripes, 0.4, 0.3, 0.25, 0.0, 0.0},
           {Pattern::kBricks, 0.5, 0.38, 1.2, 0.0, 0.0});
  addLampGrid(b, scene->hull, 5.0, 0.8, 0.5, 8.0);
  addGirders(b, scene->hull);
  addPipes(b);
  addGallery(b, b->walls[2], 3.2);
  for (int i = 0; i < 14; ++i) addMachine(b);
  for (int i = 0; i < 8; ++i) addCrates(b, true, 1.5);
  for (int i = 0; i < 3; ++i) addCupboard(b, true);
  for (Wall& wall : b->walls) {
    addDoor(b, &wall);
    for (int i = 0; i < 3; ++i) addWindow(b, &wall, 1.8, 1.4, 4.6);
    for (int i = 0; i < 4; ++i) addPoster(b, &wall);
  }
  // Lanes painted on the floor.
  const int paint = b->look(plain(0.8));
  const Box& h = scene->hull;
  for (int i = 0; i < 4; ++i) {
    const double y = random.uniform(h.min.y() + 1.0, h.max.y() - 1.0);
    b->box("lane", {h.min.x(), y, h.min.z() - kEmbed}, {h.max.x(), y + 0.1, h.min.z() + 0.002},
           paint);
    const double x = random.uniform(h.min.x() + 1.0, h.max.x() - 1.0);
    b->box("lane", {x, h.min.y(), h.min.z() - kEmbed}, {x + 0.1, h.max.y(), h.min.z() + 0.003},
           paint);
  }
}

void buildCorridor(const Box& path, Builder* b, Scene* scene) {
  Random& random = b->random;
  const int along = longAxis(path);
  const Box& h = scene->hull;
  b->shell({Pattern::kPlaster, 0.34, 0.30, 0.8, 0.0, 0.0}, plain(0.72), plain(0.6));
  addSkirting(b, 0.1, 0.15);
  const double begin = h.min[along];
  const double end = h.max[along];
  const int lamp = b->look(glowing(0.95));
  const int rim = b->look(plain(0.35));
  const double middle = 0.5 * (h.min[1 - along] + h.max[1 - along]);
  constexpr double kLampSpacing = 2.8;  // [m]
  int count = 0;
  for (double s = begin + 1.5; s < end - 1.0; s += kLampSpacing) {
    Vector3d min, max;
    min[along] = s - 0.6;
    max[along] = s + 0.6;
    min[1 - along] = middle - 0.15;
    max[1 - along] = middle + 0.15;
    min.z() = h.max.z() - 0.05;
    max.z() = h.max.z() + kEmbed;
    b->box("lamp", min, max, lamp);
    min.head<2>().array() -= 0.025;
    max.head<2>().array() += 0.025;
    min.z() += 0.01;
    b->box("lamp rim", min, max, rim);
    // One light for two lamps, see above.
    if (count++ % 2 == 1) continue;
    Vector3d light = 0.5 * (min + max);
    light[along] += 0.5 * kLampSpacing;
    light.z() = h.max.z() - 0.35;
    b->light(light, 0.32, 2.8);
  }
  for (Wall& wall : b->walls) {
    if (wall.normal == along) {  // the ends: a door each
      const double u = 0.5 * (wall.low + wall.high) - 0.5;
      b->take(&wall, u, u + 1.0, b->floor(), b->floor() + 2.2);
      addDoorAt(b, wall, u, 0.4, false);
      continue;
    }
    constexpr double kDoorSpacing = 3.2;
    const double shift = wall.inward > 0 ? 0.9 : 2.3;  // not face to face
    for (double u = wall.low + shift; u < wall.high - 1.2; u += kDoorSpacing) {
      b->take(&wall, u - 0.35, u + 1.0, b->floor(), b->floor() + 2.2);
      addDoorAt(b, wall, u, 0.42, true);
      if (wall.inward > 0) continue;
      // The handrail on one side, from door to door.
      const int look = b->look({Pattern::kPlain, 0.3, 0.3, 1.0, 0.0, 0.0});
      const Box rail = b->wallBox(wall, u + 1.1, u + kDoorSpacing - 0.45, b->floor() + 0.9,
                                  b->floor() + 0.95, 0.05, 0.09);
      b->box("handrail", rail.min, rail.max, look);
      for (const double v : {u + 1.3, u + kDoorSpacing - 0.65}) {
        const Box bracket =
            b->wallBox(wall, v, v + 0.04, b->floor() + 0.88, b->floor() + 0.92, -kEmbed, 0.07);
        b->box("bracket", bracket.min, bracket.max, look);
      }
    }
    // What few things there are: a notice, a switch, an extinguisher, at irregular places.
    const int things = static_cast<int>(wall.width() / 4.0);
    for (int i = 0; i < things; ++i) {
      const double u = random.uniform(wall.low + 0.2, wall.high - 0.9);
      const double z = b->floor();
      switch (random.index(3)) {
        case 0:
          if (!b->take(&wall, u, u + 0.6, z + 1.2, z + 1.8)) break;
          b->onWall("notice", wall, u, u + 0.6, z + 1.2, z + 1.8, 0.01, b->look(plain(0.3)));
          b->onWall("notice", wall, u + 0.05, u + 0.26, z + 1.45, z + 1.75, 0.012,
                    b->look(plain(0.85)));
          b->onWall("notice", wall, u + 0.32, u + 0.53, z + 1.3, z + 1.6, 0.012,
                    b->look({Pattern::kMosaic, 0.8, 0.2, 0.08, 0.0, 0.0}));
          break;
        case 1:
          if (!b->take(&wall, u, u + 0.08, z + 1.05, z + 1.13)) break;
          b->onWall("switch", wall, u, u + 0.08, z + 1.05, z + 1.13, 0.012, b->look(plain(0.88)));
          b->onWall("switch", wall, u + 0.025, u + 0.055, z + 1.065, z + 1.115, 0.016,
                    b->look(plain(0.5)));
          break;
        default: {
          if (!b->take(&wall, u, u + 0.2, z + 0.98, z + 1.5)) break;
          const Box tank = b->wallBox(wall, u + 0.02, u + 0.16, z + 1.0, z + 1.4, 0.02, 0.16);
          b->cylinder("extinguisher", tank.min, tank.max, 2, b->look(plain(0.22)));
          b->onWall("extinguisher sign", wall, u + 0.01, u + 0.17, z + 1.55, z + 1.71, 0.006,
                    b->look({Pattern::kStripes, 0.8, 0.2, 0.05, 45.0, 0.0}));
          break;
        }
      }
    }
  }
}

}  // namespace

const std::vector<std::string>& sceneNames() {
  static const std::vector<std::string> names = {"room",       "brick-room", "tile-room",
                                                 "blank-room", "hall",       "corridor"};
  return names;
}

bool makeScene(const SceneOptions& options, const std::vector<Vector3d>& path_w, Scene* scene,
               std::string* error) {
  const auto refuse = [error](const std::string& sentence) {
    if (error != nullptr) *error = sentence;
    return false;
  };
  const std::vector<std::string>& names = sceneNames();
  if (std::find(names.begin(), names.end(), options.kind) == names.end()) {
    std::string known;
    for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
    return refuse("scene is '" + options.kind + "', known are: " + known);
  }
  if (std::none_of(path_w.begin(), path_w.end(), [](const Vector3d& p) { return p.allFinite(); })) {
    return refuse("the path has no finite place to build a scene around");
  }

  const Box path = boundsOf(path_w);
  const bool corridor = options.kind == "corridor";
  const bool hall = options.kind == "hall";
  // Room and hall as large as EuRoC's Vicon room and machine hall.
  const Vector3d half_size = corridor ? Vector3d(0.0, 1.0, 1.35)
                             : hall   ? Vector3d(10.0, 7.5, 4.0)
                                      : Vector3d(4.0, 4.0, 2.0);
  Scene made;
  made.kind = options.kind;
  made.hull = makeHull(corridor, half_size, corridor ? 0.5 : 1.0, path);
  made.ambient = 0.35;
  Builder builder(&made, path_w, options.seed);
  if (corridor) {
    buildCorridor(path, &builder, &made);
  } else if (hall) {
    buildHall(&builder, &made);
  } else {
    buildRoom(options.kind, &builder, &made);
  }
  *scene = std::move(made);
  return true;
}

}  // namespace slim_init::simulation
