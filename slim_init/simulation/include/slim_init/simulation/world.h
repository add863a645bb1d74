// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Worlds of points and line segments on surfaces.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace slim_init::simulation {

/// Axis-aligned box [m].
using Box = Eigen::AlignedBox3d;

/// A 3D segment.
struct Segment {
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
};

/// Walls of `hull` seen from inside, furniture `obstacles` inside it that hide what is behind them,
/// and the points and segments on all these surfaces.
struct World {
  Box hull;
  std::vector<Box> obstacles;
  std::vector<Eigen::Vector3d> points;
  std::vector<Segment> segments;

  /// True when neither an obstacle nor a wall stands between two places (end points on a surface
  /// count as visible).
  bool visible(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
};

/// Kinds of worlds, by their extent and where features are: "room", "hall", "corridor".
const std::vector<std::string>& worldNames();

/// Kind and density of a world.
struct WorldOptions {
  std::string kind = "room";  ///< one of worldNames()
  /// Room and hall: points on all surfaces together. Corridor: its walls are textureless and it is
  /// as long as the path, so 1.25 % of this number stands on every 200 m^2, about 20 m of corridor.
  int points = 5000;
  /// Room and hall: segments on all surfaces together. Corridor: on every 200 m^2.
  int segments = 260;
  unsigned seed = 1;
};

/// Builds a world around a path: the hull is the kind's natural size, grown where needed so that
/// every position of `path_w` is at least a margin away from walls and obstacles. Obstacles keep
/// clear of the path; where the path leaves no room for one, there are fewer. A corridor runs along
/// the longer horizontal extent of the path (x if much the same), reaches beyond it and is
/// empty. Every point and segment lies inside the hull, on a surface or in the relief before a
/// wall. Obstacles, points and segments are independent streams derived from the seed; equal
/// options and paths give equal bytes. Without a finite position in `path_w` the world is built
/// about the origin.
World makeWorld(const WorldOptions& options, const std::vector<Eigen::Vector3d>& path_w);

}  // namespace slim_init::simulation
