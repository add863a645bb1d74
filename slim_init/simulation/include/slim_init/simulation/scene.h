// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Scenes for rendered sequences: solids with patterns on them, described once. POV-Ray draws them
// (rendering.h).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slim_init/simulation/world.h"

namespace slim_init::simulation {

/// Pattern of a surface. Lengths are Look::size_m.
enum class Pattern {
  kPlain,    ///< one brightness
  kPlaster,  ///< faint blotches of a painted wall
  kGranite,  ///< noise from `size_m` down to a fiftieth of it
  kBricks,   ///< running bond, bricks `size_m` long, joints of the brightness `dark`
  kTiles,    ///< square tiles `size_m`, joints of the brightness `dark`
  kPlanks,   ///< boards `size_m` wide with grain
  kMosaic,   ///< polygons of random brightness, `size_m` across
  kChecker,  ///< squares `size_m`
  kStripes,  ///< bars of width `size_m`
};

/// Material of a solid. Brightnesses are linear reflectances.
struct Look {
  Pattern pattern = Pattern::kPlain;
  double bright = 0.6;     ///< in [0, 1]
  double dark = 0.3;       ///< in [0, 1]; not used by kPlain
  double size_m = 0.2;     ///< of one element of the pattern
  double angle_deg = 0.0;  ///< rotation of the pattern within the surface
  double glow = 0.0;       ///< emitted brightness, for lamps and window panes
};

/// Shape of a solid.
enum class Shape { kBox, kCylinder };

/// A solid: a box along its own axes, rotated by `yaw_deg` about the vertical through its centre,
/// or a cylinder along one of its axes (elliptic where the other two half sizes differ).
struct Solid {
  std::string name;
  Shape shape = Shape::kBox;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();     ///< in w [m]
  Eigen::Vector3d half_size = Eigen::Vector3d::Ones();  ///< along its own axes [m]
  double yaw_deg = 0.0;
  int axis = 2;  ///< of a cylinder
  int look = 0;  ///< index into Scene::looks
};

/// A lamp without shadow: twice as bright at close range, falling with the square of the distance
/// at long range.
struct Light {
  Eigen::Vector3d position_w = Eigen::Vector3d::Zero();  ///< [m]
  double brightness = 0.5;                               ///< at `reach_m`
  double reach_m = 4.0;
};

/// Names of the scenes: "room", "brick-room", "hall", "corridor".
const std::vector<std::string>& sceneNames();

/// Solids, their looks and the lights: everything that rendering needs.
struct Scene {
  Box hull;  ///< space inside the walls
  double ambient = 0.3;
  std::vector<Look> looks;
  std::vector<Light> lights;
  std::vector<Solid> solids;  ///< walls included
};

/// Which scene to build.
struct SceneOptions {
  std::string kind = "room";
  unsigned seed = 1;
};

/// Builds a scene around the path of a camera: of its kind's usual size, enlarged where
/// needed so that the path keeps its distance from walls (0.5 m in the corridor, 1 m elsewhere) and
/// furniture (0.7 m). Unknown kind, or a path without a finite position: false and a message.
bool makeScene(const SceneOptions& options, const std::vector<Eigen::Vector3d>& path_w,
               Scene* scene, std::string* error);

}  // namespace slim_init::simulation
