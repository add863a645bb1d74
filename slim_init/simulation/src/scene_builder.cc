// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The built-in scenes. They are built around the path of a camera from a seed, and cannot be files:
// their size, what stands where and how many objects there are depend on both.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "hull.h"
#include "scene_parts.h"
#include "slim_init/simulation/scene.h"

namespace slim_init::simulation {
namespace {

using Eigen::Vector3d;

// Square lamps in a grid under the ceiling. Four lights stand for them all: every light has to be
// summed up for every pixel.
void addLampGrid(SceneBuilder* b, const Box& hull, double spacing, double size, double brightness,
                 double reach) {
  const int lamp = b->look(glowing(0.95));
  const int rim = b->look(plain(0.5));
  const Vector3d extent = hull.max() - hull.min();
  const auto grid = [&](int nx, int ny, const auto& place) {
    for (int i = 0; i < nx; ++i) {
      for (int j = 0; j < ny; ++j) {
        place(Vector3d(hull.min().x() + (i + 0.5) * extent.x() / nx,
                       hull.min().y() + (j + 0.5) * extent.y() / ny, hull.max().z()));
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

void buildRoom(const std::string& kind, SceneBuilder* b, Scene* scene) {
  Random& random = b->random;
  const bool bricks = kind == "brick-room";
  Look wall{Pattern::kPlaster, 0.62, 0.55, 0.6, 0.0, 0.0};
  Look floor{Pattern::kPlanks, 0.5, 0.3, 0.14, 0.0, 0.0};
  if (bricks) {
    wall = {Pattern::kBricks, 0.42, 0.68, 0.25, 0.0, 0.0};
    floor = {Pattern::kTiles, 0.45, 0.3, 0.4, 0.0, 0.0};
  }
  b->shell(floor, {Pattern::kTiles, 0.7, 0.4, 0.6, 0.0, 0.0}, wall);
  addLampGrid(b, scene->hull, 4.0, 0.6, 0.4, 3.0);
  addSkirting(b, 0.09, 0.2);
  addDoor(b, &b->walls[random.index(4)]);
  addWindow(b, &b->walls[random.index(4)], 1.8, 1.2, 1.0);
  addWindow(b, &b->walls[random.index(4)], 1.2, 1.2, 1.0);
  addRadiator(b, &b->walls[random.index(4)]);
  const int posters = bricks ? 6 : 22;
  for (int i = 0; i < posters; ++i) addPoster(b, &b->walls[i % 4]);
  for (int i = 0; i < 3; ++i) addCupboard(b);
  for (int i = 0; i < 2; ++i) addTable(b);
  for (int i = 0; i < 4; ++i) addCrates(b, 1.0);
}

// Upright girders along a wall, an H of three boxes each, and a beam under the ceiling to the wall
// on the other side.
void addGirders(SceneBuilder* b, const Box& hull) {
  const int steel = b->look({Pattern::kPlaster, 0.42, 0.3, 0.4, 0.0, 0.0});
  constexpr double kSpacing = 3.5;
  for (const Wall& wall : b->walls) {
    const int count = std::max(1, static_cast<int>(wall.width() / kSpacing));
    for (int i = 0; i < count; ++i) {
      const double u = wall.low + (i + 0.5) * wall.width() / count;
      const auto part = [&](double u0, double u1, double back, double front) {
        const Box p = b->wallBox(wall, u0, u1, b->floor(), b->ceiling(), back, front);
        if (b->clearOfPath(p, kWallClearance)) b->box("girder", p, steel);
      };
      part(u - 0.15, u + 0.15, -kEmbed, 0.03);
      part(u - 0.02, u + 0.02, 0.03, 0.27);
      part(u - 0.15, u + 0.15, 0.27, 0.30);
      if (wall.normal != 1 || wall.inward < 0) continue;
      Vector3d min(u - 0.12, hull.min().y(), b->ceiling() - 0.45);
      Vector3d max(u + 0.12, hull.max().y(), b->ceiling() - 0.15);
      if (b->clearOfPath({min, max}, kFurnitureClearance)) b->box("beam", min, max, steel);
    }
  }
}

// Pipes along the walls with clamps.
void addPipes(SceneBuilder* b) {
  Random& random = b->random;
  for (const Wall& wall : b->walls) {
    for (int i = 0; i < 2; ++i) {
      const double r = random.uniform(0.04, 0.1);
      const double z = random.uniform(b->floor() + 2.6, b->ceiling() - 0.8);
      const int look = b->look(plain(random.uniform(0.2, 0.75)));
      const Box pipe = b->wallBox(wall, wall.low, wall.high, z - r, z + r, 0.34, 0.34 + 2.0 * r);
      if (!b->clearOfPath(pipe, kWallClearance)) continue;
      b->cylinder("pipe", pipe, wall.across(), look);
      const int clamp = b->look(plain(0.15));
      for (double u = wall.low + 1.0; u < wall.high - 1.0; u += 2.0) {
        b->box("clamp",
               b->wallBox(wall, u, u + 0.06, z - 1.3 * r, z + 1.3 * r, 0.0, 0.36 + 2.0 * r), clamp);
      }
    }
  }
}

// A gallery with a railing along one wall.
void addGallery(SceneBuilder* b, const Wall& wall, double height) {
  const double z = b->floor() + height;
  const Box slab = b->wallBox(wall, wall.low, wall.high, z - 0.12, z, 0.0, 1.2);
  const Box whole = b->wallBox(wall, wall.low, wall.high, z - 0.12, z + 1.1, 0.0, 1.2);
  if (!b->clearOfPath(whole, kFurnitureClearance)) return;
  b->box("gallery", slab, b->look({Pattern::kChecker, 0.4, 0.3, 0.05, 0.0, 0.0}));
  const int rail = b->look(plain(0.65));
  for (const double h : {0.5, 1.0}) {
    b->box("rail", b->wallBox(wall, wall.low, wall.high, z + h, z + h + 0.04, 1.14, 1.18), rail);
  }
  for (double u = wall.low + 0.5; u < wall.high; u += 1.5) {
    b->box("post", b->wallBox(wall, u, u + 0.04, z, z + 1.0, 1.14, 1.18), rail);
  }
}

void buildHall(SceneBuilder* b, Scene* scene) {
  Random& random = b->random;
  b->shell({Pattern::kGranite, 0.45, 0.3, 2.0, 0.0, 0.0},
           {Pattern::kStripes, 0.4, 0.3, 0.25, 0.0, 0.0},
           {Pattern::kBricks, 0.5, 0.38, 1.2, 0.0, 0.0});
  addLampGrid(b, scene->hull, 5.0, 0.8, 0.5, 8.0);
  addGirders(b, scene->hull);
  addPipes(b);
  addGallery(b, b->walls[2], 3.2);
  for (int i = 0; i < 14; ++i) addMachine(b);
  for (int i = 0; i < 8; ++i) addCrates(b, 1.5);
  for (int i = 0; i < 3; ++i) addCupboard(b);
  for (Wall& wall : b->walls) {
    addDoor(b, &wall);
    for (int i = 0; i < 3; ++i) addWindow(b, &wall, 1.8, 1.4, 4.6);
    for (int i = 0; i < 4; ++i) addPoster(b, &wall);
  }
  // Lanes painted on the floor.
  const int paint = b->look(plain(0.8));
  const Box& h = scene->hull;
  for (int i = 0; i < 4; ++i) {
    const double y = random.uniform(h.min().y() + 1.0, h.max().y() - 1.0);
    b->box("lane", {h.min().x(), y, h.min().z() - kEmbed},
           {h.max().x(), y + 0.1, h.min().z() + 0.002}, paint);
    const double x = random.uniform(h.min().x() + 1.0, h.max().x() - 1.0);
    b->box("lane", {x, h.min().y(), h.min().z() - kEmbed},
           {x + 0.1, h.max().y(), h.min().z() + 0.003}, paint);
  }
}

// Lamps along the middle of the ceiling; one light stands for two of them (see addLampGrid()).
void addCorridorLamps(SceneBuilder* b, const Box& hull, int along) {
  constexpr double kSpacing = 2.8;  // [m]
  const int lamp = b->look(glowing(0.95));
  const int rim = b->look(plain(0.35));
  const double middle = 0.5 * (hull.min()[1 - along] + hull.max()[1 - along]);
  int count = 0;
  for (double s = hull.min()[along] + 1.5; s < hull.max()[along] - 1.0; s += kSpacing) {
    Box box = boxAlong(along, {s - 0.6, s + 0.6}, {middle - 0.15, middle + 0.15},
                       {hull.max().z() - 0.05, hull.max().z() + kEmbed});
    b->box("lamp", box, lamp);
    box.min() += Vector3d(-0.025, -0.025, 0.01);
    box.max() += Vector3d(0.025, 0.025, 0.0);
    b->box("lamp rim", box, rim);
    if (count++ % 2 == 1) continue;
    Vector3d light = 0.5 * (box.min() + box.max());
    light[along] += 0.5 * kSpacing;
    light.z() = hull.max().z() - 0.35;
    b->light(light, 0.32, 2.8);
  }
}

// A handrail on brackets, from the door at `u` to the next one at `u` + `spacing`.
void addHandrail(SceneBuilder* b, const Wall& wall, double u, double spacing) {
  const double z = b->floor();
  const int look = b->look(plain(0.3));
  b->box("handrail", b->wallBox(wall, u + 1.1, u + spacing - 0.45, z + 0.9, z + 0.95, 0.05, 0.09),
         look);
  for (const double v : {u + 1.3, u + spacing - 0.65}) {
    b->box("bracket", b->wallBox(wall, v, v + 0.04, z + 0.88, z + 0.92, -kEmbed, 0.07), look);
  }
}

// Doors along a side of the corridor. The side with the upper coordinate has handrails between
// them; its doors are offset so that none is opposite to another.
void addCorridorDoors(SceneBuilder* b, Wall* wall) {
  constexpr double kSpacing = 3.2;  // [m]
  const bool upper = wall->inward < 0.0;
  for (double u = wall->low + (upper ? 2.3 : 0.9); u < wall->high - 1.2; u += kSpacing) {
    b->take(wall, u - 0.35, u + 1.0, b->floor(), b->floor() + 2.2);
    addDoorAt(b, *wall, u, 0.42, DoorSign::kBeside);
    if (upper) addHandrail(b, *wall, u, kSpacing);
  }
}

void addNotice(SceneBuilder* b, Wall* wall, double u) {
  const double z = b->floor();
  if (!b->take(wall, u, u + 0.6, z + 1.2, z + 1.8)) return;
  b->onWall("notice", *wall, u, u + 0.6, z + 1.2, z + 1.8, 0.01, b->look(plain(0.3)));
  b->onWall("notice", *wall, u + 0.05, u + 0.26, z + 1.45, z + 1.75, 0.012, b->look(plain(0.85)));
  b->onWall("notice", *wall, u + 0.32, u + 0.53, z + 1.3, z + 1.6, 0.012,
            b->look({Pattern::kMosaic, 0.8, 0.2, 0.08, 0.0, 0.0}));
}

void addSwitch(SceneBuilder* b, Wall* wall, double u) {
  const double z = b->floor();
  if (!b->take(wall, u, u + 0.08, z + 1.05, z + 1.13)) return;
  b->onWall("switch", *wall, u, u + 0.08, z + 1.05, z + 1.13, 0.012, b->look(plain(0.88)));
  b->onWall("switch", *wall, u + 0.025, u + 0.055, z + 1.065, z + 1.115, 0.016,
            b->look(plain(0.5)));
}

void addExtinguisher(SceneBuilder* b, Wall* wall, double u) {
  const double z = b->floor();
  if (!b->take(wall, u, u + 0.2, z + 0.98, z + 1.5)) return;
  const Box tank = b->wallBox(*wall, u + 0.02, u + 0.16, z + 1.0, z + 1.4, 0.02, 0.16);
  b->cylinder("extinguisher", tank, 2, b->look(plain(0.22)));
  b->onWall("extinguisher sign", *wall, u + 0.01, u + 0.17, z + 1.55, z + 1.71, 0.006,
            b->look({Pattern::kStripes, 0.8, 0.2, 0.05, 45.0, 0.0}));
}

// The few objects on a side of the corridor, at irregular places.
void addSmallObjects(SceneBuilder* b, Wall* wall) {
  const int objects = static_cast<int>(wall->width() / 4.0);
  for (int i = 0; i < objects; ++i) {
    const double u = b->random.uniform(wall->low + 0.2, wall->high - 0.9);
    switch (b->random.index(3)) {
      case 0: addNotice(b, wall, u); break;
      case 1: addSwitch(b, wall, u); break;
      default: addExtinguisher(b, wall, u); break;
    }
  }
}

void buildCorridor(const Box& path, SceneBuilder* b, Scene* scene) {
  const int along = longAxis(path);
  b->shell({Pattern::kPlaster, 0.34, 0.30, 0.8, 0.0, 0.0}, plain(0.72), plain(0.6));
  addSkirting(b, 0.1, 0.15);
  addCorridorLamps(b, scene->hull, along);
  for (Wall& wall : b->walls) {
    if (wall.normal == along) {  // an end: one door
      const double u = 0.5 * (wall.low + wall.high) - 0.5;
      b->take(&wall, u, u + 1.0, b->floor(), b->floor() + 2.2);
      addDoorAt(b, wall, u, 0.4, DoorSign::kNone);
      continue;
    }
    addCorridorDoors(b, &wall);
    addSmallObjects(b, &wall);
  }
}

}  // namespace

const std::vector<std::string>& sceneNames() {
  static const std::vector<std::string> names = {"room", "brick-room", "hall", "corridor"};
  return names;
}

bool makeScene(const SceneOptions& options, const std::vector<Vector3d>& path_w, Scene* scene,
               std::string* error) {
  const auto refuse = [error](const std::string& message) {
    if (error != nullptr) *error = message;
    return false;
  };
  const std::vector<std::string>& names = sceneNames();
  if (std::find(names.begin(), names.end(), options.kind) == names.end()) {
    std::string known;
    for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
    return refuse("scene is '" + options.kind + "', must be one of: " + known);
  }
  if (std::none_of(path_w.begin(), path_w.end(), [](const Vector3d& p) { return p.allFinite(); })) {
    return refuse("the path has no finite position to build a scene around");
  }

  const Box path = boundsOf(path_w);
  Scene made;
  made.hull = makeHull(options.kind, path);
  made.ambient = 0.35;
  SceneBuilder builder(&made, path_w, options.seed);
  if (options.kind == "corridor") {
    buildCorridor(path, &builder, &made);
  } else if (options.kind == "hall") {
    buildHall(&builder, &made);
  } else {
    buildRoom(options.kind, &builder, &made);
  }
  *scene = std::move(made);
  return true;
}

}  // namespace slim_init::simulation
