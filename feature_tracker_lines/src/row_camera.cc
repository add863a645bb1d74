// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "row_camera.h"

#include "geometry/so3.h"
#include "slim_init/types.h"

namespace slim_init::feature_tracker_lines {
namespace {

// Each step takes off all but the share of the image height that a point crosses during the
// readout, a tenth in a fast turn: four leave less than a hundredth of a pixel.
constexpr int kRowSteps = 4;

}  // namespace

RowCamera::RowCamera(const Camera& camera, const RowExposure& rows)
    : camera_(camera), rows_(rows) {}

Eigen::Vector3d RowCamera::bearing(const Eigen::Vector2d& pixel) const {
  return atMiddleRow(camera_.bearing(pixel), pixel.y());
}

bool RowCamera::project(const Eigen::Vector3d& direction, Eigen::Vector2d* pixel) const {
  if (!(rows_.readout_s > 0.0)) return camera_.project(direction, pixel);
  Eigen::Vector2d seen;
  if (!camera_.project(direction, &seen)) return false;
  for (int step = 0; step < kRowSteps; ++step) {
    if (!camera_.project(atOwnRow(direction, seen.y()), &seen)) return false;
  }
  *pixel = seen;
  return true;
}

Eigen::Vector3d RowCamera::atOwnRow(const Eigen::Vector3d& direction, double v) const {
  if (!(rows_.readout_s > 0.0)) return direction;
  const double dt = rowTime(v, camera_.parameters().height, rows_.readout_s);
  return expSO3(-dt * rows_.rate_c) * direction;
}

Eigen::Vector3d RowCamera::atMiddleRow(const Eigen::Vector3d& direction, double v) const {
  if (!(rows_.readout_s > 0.0)) return direction;
  const double dt = rowTime(v, camera_.parameters().height, rows_.readout_s);
  return expSO3(dt * rows_.rate_c) * direction;
}

}  // namespace slim_init::feature_tracker_lines
