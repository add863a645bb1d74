// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "slim_init/simulation/scene.h"

namespace slim_init::simulation {

/// Rotation from w to the solid's own axes.
inline Eigen::Vector3d toOwn(const Solid& solid, const Eigen::Vector3d& v_w) {
  const double yaw = solid.yaw_deg * 3.141592653589793 / 180.0;
  const double c = std::cos(yaw), s = std::sin(yaw);
  return {c * v_w.x() + s * v_w.y(), -s * v_w.x() + c * v_w.y(), v_w.z()};
}

/// Distance along a ray to the solid, in units of `direction_w`; infinite where it is not met.
inline double distanceTo(const Solid& solid, const Eigen::Vector3d& origin_w,
                         const Eigen::Vector3d& direction_w) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d o = toOwn(solid, origin_w - solid.center).cwiseQuotient(solid.half_size);
  const Eigen::Vector3d d = toOwn(solid, direction_w).cwiseQuotient(solid.half_size);
  const bool box = solid.shape == Shape::kBox;
  double enter = 0.0, leave = kNone;
  for (int axis = 0; axis < 3; ++axis) {
    if (!box && axis != solid.axis) continue;
    const double a = (-1.0 - o[axis]) / d[axis], b = (1.0 - o[axis]) / d[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (!box) {
    Eigen::Vector3d p = o, v = d;
    p[solid.axis] = v[solid.axis] = 0.0;
    const double root = std::sqrt(p.dot(v) * p.dot(v) - v.dot(v) * (p.dot(p) - 1.0));
    if (std::isnan(root)) return kNone;
    enter = std::max(enter, (-p.dot(v) - root) / v.dot(v));
    leave = std::min(leave, (-p.dot(v) + root) / v.dot(v));
  }
  return enter <= leave ? enter : kNone;
}

/// Index of the solid that a ray meets first; -1: none.
inline int firstSolid(const Scene& scene, const Eigen::Vector3d& origin_w,
                      const Eigen::Vector3d& direction_w) {
  int first = -1;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < scene.solids.size(); ++i) {
    const double distance = distanceTo(scene.solids[i], origin_w, direction_w);
    if (!(distance < nearest)) continue;
    nearest = distance;
    first = static_cast<int>(i);
  }
  return first;
}

}  // namespace slim_init::simulation
