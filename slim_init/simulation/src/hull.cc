// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "hull.h"

namespace slim_init::simulation {
namespace {

constexpr double kCorridorOverrun =
    10.0;  // [m] beyond the path, so that the camera never faces an end wall at close range
constexpr double kCorridorEyeHeight = 1.5;  // [m] of the path's middle above the floor
constexpr double kCorridorHeight = 2.7;     // [m]

}  // namespace

Box boundsOf(const std::vector<Eigen::Vector3d>& path_w) {
  Box box;
  for (const Eigen::Vector3d& p : path_w) {
    if (p.allFinite()) box.extend(p);
  }
  return box.isEmpty() ? Box(Eigen::Vector3d(Eigen::Vector3d::Zero())) : box;
}

Box grown(const Box& box, double by) {
  return {box.min() - Eigen::Vector3d::Constant(by), box.max() + Eigen::Vector3d::Constant(by)};
}

int longAxis(const Box& box) {
  const Eigen::Vector3d size = box.sizes();
  constexpr double kClearlyLonger = 1.25;
  constexpr double kStill = 0.1;  // [m]; the vibration of a vehicle at rest has no direction
  return size.y() > kClearlyLonger * size.x() + kStill ? 1 : 0;
}

Box makeHull(const std::string& kind, const Box& path) {
  const bool corridor = kind == "corridor";
  // As large as EuRoC's machine hall and Vicon room [m]; of a corridor half the width counts.
  const Eigen::Vector3d half_size = corridor         ? Eigen::Vector3d(0.0, 1.0, 1.35)
                                    : kind == "hall" ? Eigen::Vector3d(10.0, 7.5, 4.0)
                                                     : Eigen::Vector3d(4.0, 4.0, 2.0);
  const Eigen::Vector3d center = path.center();
  Box hull{center - half_size, center + half_size};
  if (corridor) {
    const int along = longAxis(path);
    const int across = 1 - along;
    hull.min()[along] = path.min()[along] - kCorridorOverrun;
    hull.max()[along] = path.max()[along] + kCorridorOverrun;
    hull.min()[across] = center[across] - half_size.y();
    hull.max()[across] = center[across] + half_size.y();
    hull.min().z() = center.z() - kCorridorEyeHeight;
    hull.max().z() = hull.min().z() + kCorridorHeight;
  }
  return hull.merged(grown(path, corridor ? 0.5 : 1.0));
}

}  // namespace slim_init::simulation
