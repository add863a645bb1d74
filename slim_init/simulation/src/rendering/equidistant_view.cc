// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "slim_init/simulation/rendering.h"
#include "slim_init/text.h"

namespace slim_init::simulation {
namespace {

// Angles from the axis, as a vector: its length is the angle.
Eigen::Vector2d anglesOf(const Eigen::Vector3d& direction) {
  const double radius = direction.head<2>().norm();
  if (radius == 0.0) return Eigen::Vector2d::Zero();
  return std::atan2(radius, direction.z()) / radius * direction.head<2>();
}

}  // namespace

Eigen::Vector2d EquidistantView::project(const Eigen::Vector3d& direction) const {
  return px_per_rad * anglesOf(direction) + 0.5 * Eigen::Vector2d(width - 1.0, height - 1.0);
}

bool makeEquidistantView(const feature_tracker_lines::Camera& camera, EquidistantView* view,
                         std::string* error) {
  constexpr double kMaxAngle = 87.5 * M_PI / 180.0;
  constexpr double kMargin = 2.0;  // [px], for the resampling
  const auto& parameters = camera.parameters();
  Eigen::Vector2d largest = Eigen::Vector2d::Zero();
  double largest_angle = 0.0;
  // The extremes are on the border.
  const auto look = [&](double u, double v) {
    const Eigen::Vector2d angles = anglesOf(camera.bearing({u, v}));
    if (!(angles.norm() <= kMaxAngle)) {
      if (error != nullptr)
        *error = text(
            "pixel (", u, ", ", v, ") of the camera ",
            (angles.allFinite() ? "looks more than 87.5 deg away from its axis" : "has no ray"),
            ", which cannot be rendered");
      return false;
    }
    largest = largest.cwiseMax(angles.cwiseAbs());
    largest_angle = std::max(largest_angle, angles.norm());
    return true;
  };
  for (int u = 0; u < parameters.width; ++u) {
    if (!look(u, 0.0) || !look(u, parameters.height - 1.0)) return false;
  }
  for (int v = 0; v < parameters.height; ++v) {
    if (!look(0.0, v) || !look(parameters.width - 1.0, v)) return false;
  }
  view->px_per_rad = camera.focalPx();
  view->width = 2 * static_cast<int>(std::ceil(view->px_per_rad * largest.x() + kMargin));
  view->height = 2 * static_cast<int>(std::ceil(view->px_per_rad * largest.y() + kMargin));
  // The corners of the picture are farther out than those of the image.
  const double corner = 0.5 * std::hypot(view->width, view->height) / view->px_per_rad;
  view->full_angle_rad = 2.0 * std::max(largest_angle, corner) * 1.001;
  return true;
}

}  // namespace slim_init::simulation
