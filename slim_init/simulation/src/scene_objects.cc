// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Objects of the built-in scenes, on their walls and on their floor.
#include <algorithm>
#include <utility>

#include "scene_parts.h"

namespace slim_init::simulation {

using Eigen::Vector3d;

// ---------------------------------------------------------------------------------- on the walls

Look posterLook(Random* random) {
  static constexpr struct {
    Pattern pattern;
    double least_m, largest_m, most_deg;
  } kKinds[] = {{Pattern::kMosaic, 0.05, 0.18, 0.0},
                {Pattern::kMosaic, 0.12, 0.3, 0.0},
                {Pattern::kGranite, 0.4, 1.0, 0.0},
                {Pattern::kChecker, 0.08, 0.2, 90.0},
                {Pattern::kStripes, 0.06, 0.2, 180.0}};
  Look look;
  look.dark = random->uniform(0.05, 0.2);
  look.bright = random->uniform(0.5, 0.9);
  const auto& kind = kKinds[random->index(5)];
  look.pattern = kind.pattern;
  look.size_m = random->uniform(kind.least_m, kind.largest_m);
  if (kind.most_deg > 0.0) look.angle_deg = random->uniform(0.0, kind.most_deg);
  return look;
}

void addPoster(SceneBuilder* b, Wall* wall) {
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

void addDoorAt(SceneBuilder* b, const Wall& wall, double u, double leaf_brightness, DoorSign sign) {
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
  if (sign == DoorSign::kBeside) {
    const double v = u - 0.3;
    b->onWall("sign", wall, v, v + 0.2, z + 1.55, z + 1.7, 0.008, b->look(plain(0.9)));
    Random& random = b->random;
    for (int i = 0; i < 3; ++i) {
      const double g = v + 0.03 + 0.05 * i;
      const double top = random.uniform(1.63, 1.67), width = random.uniform(0.015, 0.04);
      b->onWall("sign print", wall, g, g + width, z + 1.6, z + top, 0.0095, dark);
    }
  }
}

void addDoor(SceneBuilder* b, Wall* wall) {
  double u = 0.0;
  if (b->hanging(wall, 1.0, 2.2, b->floor(), &u)) addDoorAt(b, *wall, u, 0.35, DoorSign::kNone);
}

void addWindow(SceneBuilder* b, Wall* wall, double w, double h, double sill) {
  const double z = b->floor() + sill;
  double u = 0.0;
  if (!b->hanging(wall, w, h, z, &u)) return;
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
}

// A radiator: upright ribs between two rails.
void addRadiator(SceneBuilder* b, Wall* wall) {
  const double w = 1.0, z = b->floor() + 0.12;
  double u = 0.0;
  if (!b->hanging(wall, w, 0.6, z, &u)) return;
  const int look = b->look(plain(0.72));
  for (int i = 0; i < 10; ++i) {
    const double a = u + 0.1 * i;
    b->box("rib", b->wallBox(*wall, a, a + 0.06, z, z + 0.6, 0.03, 0.11), look);
  }
  b->box("rail", b->wallBox(*wall, u, u + w, z + 0.05, z + 0.1, 0.04, 0.1), look);
}

void addSkirting(SceneBuilder* b, double height, double brightness) {
  const int look = b->look(plain(brightness));
  for (const Wall& wall : b->walls) {
    b->onWall("skirting", wall, wall.low, wall.high, b->floor(), b->floor() + height, 0.015, look);
  }
}

// ---------------------------------------------------------------------------------- on the floor

namespace {

// One number after the other, the height first: arguments of a call have no order that all
// compilers share.
Vector3d drawSize(Random* random, const Range& x, const Range& y, const Range& z) {
  const double height = random->uniform(z.low, z.high);
  const double depth = random->uniform(y.low, y.high);
  return Vector3d(random->uniform(x.low, x.high), depth, height);
}

// Turns every other object by a right angle; returns the axis of its first extent.
int drawAxis(Random* random, Vector3d* size) {
  if (random->uniform() >= 0.5) return 0;
  std::swap(size->x(), size->y());
  return 1;
}

}  // namespace

void addCupboard(SceneBuilder* b) {
  Random& random = b->random;
  Vector3d size = drawSize(&random, {0.8, 1.5}, {0.4, 0.7}, {0.8, 1.9});
  const int axis = drawAxis(&random, &size);
  Box place;
  if (!b->standing(size, Standing::kAlongWalls, &place)) return;
  const Look body{
      Pattern::kPlanks, random.uniform(0.4, 0.6), random.uniform(0.2, 0.35), 0.15, 0.0, 0.0};
  b->box("cupboard", place, b->look(body));
  // Doors stand 1 cm proud on all four long sides, so that whichever is seen has them.
  const int door = b->look(plain(random.uniform(0.25, 0.65)));
  const int knob = b->look(plain(0.1));
  const double half = 0.5 * (place.max()[axis] - place.min()[axis]);
  for (int i = 0; i < 2; ++i) {
    const Box leaf = boxAlong(
        axis, {place.min()[axis] + i * half + 0.03, place.min()[axis] + (i + 1) * half - 0.03},
        {place.min()[1 - axis] - 0.01, place.max()[1 - axis] + 0.01},
        {place.min().z() + 0.08, place.max().z() - 0.05});
    b->box("cupboard door", leaf, door);
    const double u = i == 0 ? leaf.max()[axis] - 0.06 : leaf.min()[axis] + 0.03;
    const double z = 0.5 * (leaf.min().z() + leaf.max().z()) - 0.08;
    b->box("knob",
           boxAlong(axis, {u, u + 0.03}, {leaf.min()[1 - axis] - 0.02, leaf.max()[1 - axis] + 0.02},
                    {z, z + 0.16}),
           knob);
  }
}

void addTable(SceneBuilder* b) {
  Random& random = b->random;
  const double depth = random.uniform(0.6, 0.9), width = random.uniform(1.0, 1.6);
  const Vector3d size(width, depth, 0.74);
  Box place;
  if (!b->standing(size, Standing::kAnywhere, &place)) return;
  const Look top{Pattern::kPlanks, 0.55, 0.35, 0.12, 0.0, 0.0};
  b->box("table top", {place.min().x(), place.min().y(), place.max().z() - 0.04}, place.max(),
         b->look(top));
  const int leg = b->look(plain(0.15));
  for (int i = 0; i < 4; ++i) {
    const double x = i % 2 == 0 ? place.min().x() + 0.03 : place.max().x() - 0.08;
    const double y = i / 2 == 0 ? place.min().y() + 0.03 : place.max().y() - 0.08;
    b->box("table leg", {x, y, place.min().z()}, {x + 0.05, y + 0.05, place.max().z() - 0.04}, leg);
  }
  // Books and boxes on it.
  const int things = 2 + random.index(3);
  for (int i = 0; i < things; ++i) {
    const double x = random.uniform(place.min().x() + 0.2, place.max().x() - 0.2);
    const double y = random.uniform(place.min().y() + 0.2, place.max().y() - 0.2);
    const Vector3d half = drawSize(&random, {0.06, 0.16}, {0.05, 0.12}, {0.03, 0.18});
    const Vector3d center(x, y, place.max().z() + half.z());
    const double turn_deg = random.uniform(-60.0, 60.0);
    b->box("thing", center - half, center + half, b->look(posterLook(&random)), turn_deg);
  }
}

void addCrates(SceneBuilder* b, double scale) {
  Random& random = b->random;
  const double s = scale * random.uniform(0.4, 0.8);
  Box place;
  // The diagonal of the crate, which is turned.
  const double side = 1.42 * s;
  if (!b->standing({side, side, 1.7 * s}, Standing::kAnywhere, &place)) return;
  const Vector3d foot(0.5 * (place.min().x() + place.max().x()),
                      0.5 * (place.min().y() + place.max().y()), place.min().z());
  const auto crate = [&](double size, double base) {
    const double yaw = random.uniform(-45.0, 45.0);
    const Vector3d half(0.5 * size, 0.5 * size, 0.5 * size);
    const Vector3d center = foot + Vector3d(0.0, 0.0, base + half.z());
    const Look body{Pattern::kPlanks,          random.uniform(0.45, 0.65),
                    random.uniform(0.2, 0.35), 0.12,
                    90.0 * random.index(2),    0.0};
    b->box("crate", center - half, center + half, b->look(body), yaw);
    // Battens around it.
    const int batten = b->look(plain(0.25));
    for (const double z : {-0.38, 0.38}) {
      const Vector3d rim(1.06 * half.x(), 1.06 * half.y(), 0.06 * size);
      const Vector3d at = center + Vector3d(0.0, 0.0, z * size);
      b->box("batten", at - rim, at + rim, batten, yaw);
    }
  };
  crate(s, 0.0);
  if (random.uniform() < 0.6) crate(0.7 * s, s);
}

namespace {

Look panelLook(Random* random) {
  switch (random->index(5)) {
    case 0: return {Pattern::kStripes, 0.6, 0.1, 0.05, 90.0 * random->index(2), 0.0};
    case 1: return {Pattern::kMosaic, 0.75, 0.1, random->uniform(0.06, 0.2), 0.0, 0.0};
    case 2: return {Pattern::kChecker, 0.5, 0.2, 0.08, 0.0, 0.0};
    default: return plain(random->uniform(0.1, 0.75));
  }
}

// Dials and bolts, which stand out of both faces of a panel.
void addDials(SceneBuilder* b, const Box& panel, int normal) {
  Random& random = b->random;
  const int across = 1 - normal;
  const int dial = b->look(plain(random.uniform() < 0.5 ? 0.85 : 0.05));
  for (int i = 0; i < 3; ++i) {
    const double a = random.uniform(panel.min()[across] + 0.03, panel.max()[across] - 0.1);
    const double z = random.uniform(panel.min().z() + 0.03, panel.max().z() - 0.1);
    const double width = random.uniform(0.03, 0.07), height = random.uniform(0.03, 0.07);
    b->box("dial",
           boxAlong(normal, {panel.min()[normal] - 0.012, panel.max()[normal] + 0.012},
                    {a, a + width}, {z, z + height}),
           dial);
  }
}

// Panels side by side on one side of a machine, up to the height `top`.
void addPanels(SceneBuilder* b, const Box& place, int side, double top) {
  Random& random = b->random;
  const int normal = side / 2;
  const int across = 1 - normal;
  const double place_n = side % 2 == 0 ? place.min()[normal] + 0.05 : place.max()[normal] - 0.05;
  double u = place.min()[across] + 0.15;
  while (place.max()[across] - u > 0.5) {
    const double w = std::min(random.uniform(0.35, 0.9), place.max()[across] - 0.15 - u);
    const double z0 = random.uniform(place.min().z() + 0.3, place.min().z() + 0.5);
    const double z1 = std::min(top - 0.1, z0 + random.uniform(0.4, 1.5));
    if (w > 0.2 && z1 - z0 > 0.2) {
      const Box panel = boxAlong(normal, {place_n - 0.02, place_n + 0.02}, {u, u + w}, {z0, z1});
      b->box("panel", panel, b->look(panelLook(&random)));
      addDials(b, panel, normal);
    }
    u += w + random.uniform(0.08, 0.3);
  }
}

// A motor on a machine, and a pipe from it to the ceiling where the path leaves space.
void addMotorAndPipe(SceneBuilder* b, const Box& place, double top) {
  Random& random = b->random;
  const double y = random.uniform(place.min().y() + 0.2, place.max().y() - 0.7);
  const double x = random.uniform(place.min().x() + 0.2, place.max().x() - 0.7);
  const Vector3d motor(x, y, top);
  b->box("motor", motor, {motor.x() + 0.5, motor.y() + 0.4, place.max().z()},
         b->look({Pattern::kStripes, 0.45, 0.15, 0.04, 0.0, 0.0}));
  const double r = random.uniform(0.05, 0.12);
  const Vector3d foot(place.min().x() + 0.1 + r, place.min().y() + 0.1 + r, top);
  const Box pipe = boxAlong(0, {foot.x() - r, foot.x() + r}, {foot.y() - r, foot.y() + r},
                            {foot.z(), b->ceiling()});
  if (b->clearOfPath(pipe, kFurnitureClearance)) {
    b->cylinder("pipe", pipe, 2, b->look(plain(random.uniform(0.3, 0.7))));
  }
}

}  // namespace

void addMachine(SceneBuilder* b) {
  Random& random = b->random;
  Vector3d size = drawSize(&random, {1.2, 3.5}, {1.0, 2.2}, {1.2, 3.0});
  drawAxis(&random, &size);
  const Standing where = random.uniform() < 0.5 ? Standing::kAlongWalls : Standing::kAnywhere;
  Box place;
  if (!b->standing(size, where, &place)) return;
  // The motor takes the upper quarter.
  Vector3d top = place.max();
  top.z() -= 0.25 * (place.max().z() - place.min().z());
  Look body{Pattern::kGranite, random.uniform(0.35, 0.6), random.uniform(0.2, 0.3), 1.5, 0.0, 0.0};
  b->box("machine base", place.min(), {top.x(), top.y(), place.min().z() + 0.15},
         b->look(plain(0.12)));
  b->box("machine", {place.min().x() + 0.05, place.min().y() + 0.05, place.min().z() + 0.15},
         {top.x() - 0.05, top.y() - 0.05, top.z()}, b->look(body));
  for (int side = 0; side < 4; ++side) addPanels(b, place, side, top.z());
  addMotorAndPipe(b, place, top.z());
}

}  // namespace slim_init::simulation
