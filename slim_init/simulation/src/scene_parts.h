// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Parts that the built-in scenes are put together from (scene_builder.cc). Internal.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <vector>

#include "hull.h"
#include "random.h"
#include "slim_init/simulation/scene.h"

namespace slim_init::simulation {

inline constexpr double kWallThickness = 0.2;       ///< [m]
inline constexpr double kFurnitureClearance = 0.7;  ///< to the path [m]
inline constexpr double kWallClearance = 0.5;       ///< of what is fixed to a wall, to the path [m]
inline constexpr double kGap = 0.1;                 ///< between objects on a wall or a floor [m]
inline constexpr double kEmbed = 0.01;  ///< depth to which objects on a wall reach into it [m]
inline constexpr int kMaxTries = 60;    ///< draws for the place of one object
/// Distance of the places on the path that are checked [m]: small against the clearances.
inline constexpr double kPathStep = 0.03;

/// A surface of one brightness.
inline Look plain(double bright) { return {Pattern::kPlain, bright, bright, 1.0, 0.0, 0.0}; }
/// A lamp or a window pane.
inline Look glowing(double glow) { return {Pattern::kPlain, 0.3, 0.3, 1.0, 0.0, glow}; }

/// Where an object on the floor is placed: anywhere, or along the walls while there is space.
enum class Standing { kAnywhere, kAlongWalls };
/// Whether a door has a sign with print beside it.
enum class DoorSign { kNone, kBeside };

/// An interval [m].
struct Range {
  double low, high;
};
/// A box by its extents along a horizontal axis, across it and upwards.
inline Box boxAlong(int axis, const Range& along, const Range& across, const Range& up) {
  Box box;
  box.min()[axis] = along.low;
  box.max()[axis] = along.high;
  box.min()[1 - axis] = across.low;
  box.max()[1 - axis] = across.high;
  box.min().z() = up.low;
  box.max().z() = up.high;
  return box;
}

/// An upright wall, seen from inside.
struct Wall {
  int normal = 0;       ///< axis
  double place = 0.0;   ///< coordinate of its surface along `normal` [m]
  double inward = 1.0;  ///< direction along `normal` to the inside
  double low = 0.0;     ///< extent along the other horizontal axis [m]
  double high = 0.0;
  std::vector<Box> taken;  ///< by what hangs there: u, z, unused

  int across() const { return 1 - normal; }
  double width() const { return high - low; }
};

/// Puts objects into a scene and keeps the camera's path free.
///
/// All randomness of a scene comes from `random`: equal seeds give equal scenes.
class SceneBuilder {
 public:
  SceneBuilder(Scene* scene, const std::vector<Eigen::Vector3d>& path_w, unsigned seed)
      : random(seed, "scene"), scene_(scene) {
    for (const Eigen::Vector3d& p : path_w) {
      if (!p.allFinite()) continue;
      if (path_.empty() || (p - path_.back()).norm() >= kPathStep) path_.push_back(p);
    }
    const Box& hull = scene->hull;
    for (int normal = 0; normal < 2; ++normal) {
      for (const bool upper : {false, true}) {
        Wall wall;
        wall.normal = normal;
        wall.place = upper ? hull.max()[normal] : hull.min()[normal];
        wall.inward = upper ? -1.0 : 1.0;
        wall.low = hull.min()[1 - normal];
        wall.high = hull.max()[1 - normal];
        walls.push_back(wall);
      }
    }
  }

  Random random;
  std::vector<Wall> walls;

  double floor() const { return scene_->hull.min().z(); }
  double ceiling() const { return scene_->hull.max().z(); }

  /// Adds a look; returns its index.
  int look(const Look& look) {
    scene_->looks.push_back(look);
    return static_cast<int>(scene_->looks.size()) - 1;
  }

  void box(const std::string& name, const Eigen::Vector3d& min, const Eigen::Vector3d& max,
           int look, double yaw_deg = 0.0) {
    Solid solid;
    solid.name = name;
    solid.center = 0.5 * (min + max);
    solid.half_size = 0.5 * (max - min);
    solid.yaw_deg = yaw_deg;
    solid.look = look;
    scene_->solids.push_back(solid);
  }

  void box(const std::string& name, const Box& b, int look) { box(name, b.min(), b.max(), look); }

  void cylinder(const std::string& name, const Box& b, int axis, int look) {
    box(name, b, look);
    scene_->solids.back().shape = Shape::kCylinder;
    scene_->solids.back().axis = axis;
  }

  /// Floor, ceiling and four walls. Every wall gets a look of its own, since patterns that meet in
  /// a corner do not continue around it.
  void shell(const Look& floor_look, const Look& ceiling_look, const Look& wall_look) {
    const Box& h = scene_->hull;
    const Eigen::Vector3d t = Eigen::Vector3d::Constant(kWallThickness);
    box("floor", {h.min().x() - t.x(), h.min().y() - t.y(), h.min().z() - t.z()},
        {h.max().x() + t.x(), h.max().y() + t.y(), h.min().z()}, look(floor_look));
    box("ceiling", {h.min().x() - t.x(), h.min().y() - t.y(), h.max().z()},
        {h.max().x() + t.x(), h.max().y() + t.y(), h.max().z() + t.z()}, look(ceiling_look));
    for (const Wall& wall : walls) {
      box("wall",
          wallBox(wall, wall.low, wall.high, h.min().z(), h.max().z(), -kWallThickness, 0.0),
          look(wall_look));
    }
  }

  /// Corners of a box that stands out of a wall from `back` to `front` [m]; `u` along the wall, `z`
  /// upwards.
  Box wallBox(const Wall& wall, double u0, double u1, double z0, double z1, double back,
              double front) const {
    const double a = wall.place + wall.inward * back;
    const double b = wall.place + wall.inward * front;
    return boxAlong(wall.normal, {std::min(a, b), std::max(a, b)}, {u0, u1}, {z0, z1});
  }
  /// A box on a wall that stands out by `depth` [m].
  void onWall(const std::string& name, const Wall& wall, double u0, double u1, double z0, double z1,
              double depth, int look) {
    box(name, wallBox(wall, u0, u1, z0, z1, -kEmbed, depth), look);
  }

  /// Reserves a part of a wall. False where it is not free.
  bool take(Wall* wall, double u0, double u1, double z0, double z1) {
    if (u0 < wall->low + kGap || u1 > wall->high - kGap || z0 < floor() || z1 > ceiling()) {
      return false;
    }
    const Box part(Eigen::Vector3d(u0, z0, 0.0), Eigen::Vector3d(u1, z1, 0.0));
    if (isNear(part, wall->taken)) return false;
    wall->taken.push_back(part);
    return true;
  }
  /// The same for an object of width `w` and height `h` from `z` up [m] at a free place, whose left
  /// end is `u`. False where none is found.
  bool hanging(Wall* wall, double w, double h, double z, double* u) {
    for (int attempt = 0; attempt < kMaxTries; ++attempt) {
      *u = random.uniform(wall->low, wall->high - w);
      if (take(wall, *u, *u + w, z, z + h)) return true;
    }
    return false;
  }

  /// Whether the box keeps its distance from the path [m].
  bool clearOfPath(const Box& b, double clearance) const {
    return std::none_of(path_.begin(), path_.end(), [&](const Eigen::Vector3d& p) {
      return b.exteriorDistance(p) < clearance;
    });
  }

  /// A free place on the floor for an object of this size. False where none is found.
  bool standing(const Eigen::Vector3d& size, Standing where, Box* place) {
    const Box& h = scene_->hull;
    for (int attempt = 0; attempt < kMaxTries; ++attempt) {
      Box b;
      for (int axis = 0; axis < 2; ++axis) {
        const double free = h.max()[axis] - h.min()[axis] - size[axis] - 2.0 * kGap;
        if (free < 0.0) return false;
        b.min()[axis] = h.min()[axis] + kGap + random.uniform() * free;
      }
      if (where == Standing::kAlongWalls && attempt < kMaxTries / 2) {
        const int axis = random.index(2);
        b.min()[axis] =
            random.uniform() < 0.5 ? h.min()[axis] + kGap : h.max()[axis] - kGap - size[axis];
      }
      b.min().z() = h.min().z();
      b.max() = b.min() + size;
      if (isNear(b, standing_) || !clearOfPath(b, kFurnitureClearance)) continue;
      standing_.push_back(b);
      *place = b;
      return true;
    }
    return false;
  }

  void light(const Eigen::Vector3d& position, double brightness, double reach) {
    scene_->lights.push_back({position, brightness, reach});
  }

 private:
  static bool isNear(const Box& box, const std::vector<Box>& others) {
    return std::any_of(others.begin(), others.end(),
                       [&box](const Box& other) { return grown(box, kGap).intersects(other); });
  }

  Scene* scene_;
  std::vector<Eigen::Vector3d> path_;  // of the camera [m]
  std::vector<Box> standing_;          // objects on the floor
};

// Objects on walls (scene_objects.cc). Those without a given place look for a free one at random
// and are left out where there is none.
void addPoster(SceneBuilder* b, Wall* wall);
/// Door with its left post at `u`; 1 m wide, 2.1 m high.
void addDoorAt(SceneBuilder* b, const Wall& wall, double u, double leaf_brightness, DoorSign sign);
void addDoor(SceneBuilder* b, Wall* wall);
/// Window of width `w` and height `h`, `sill` above the floor [m].
void addWindow(SceneBuilder* b, Wall* wall, double w, double h, double sill);
void addRadiator(SceneBuilder* b, Wall* wall);
void addSkirting(SceneBuilder* b, double height, double brightness);

// Objects on the floor, at random free places.
void addCupboard(SceneBuilder* b);
void addTable(SceneBuilder* b);
/// One crate or two, one on the other; 0.4 m to 0.8 m times `scale`.
void addCrates(SceneBuilder* b, double scale);
/// A machine: a body with panels, a motor and a pipe to the ceiling.
void addMachine(SceneBuilder* b);

/// A random pattern as of a poster or picture.
Look posterLook(Random* random);

}  // namespace slim_init::simulation
