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

Eigen::Vector3d RowExposure::atMiddleRow(const Eigen::Vector3d& bearing, double v,
                                         int height) const {
  if (!(readout_s > 0.0)) return bearing;
  return expSO3(rowTime(v, height, readout_s) * rate_c) * bearing;
}

Eigen::Vector3d RowExposure::atRow(const Eigen::Vector3d& bearing, double v, int height) const {
  if (!(readout_s > 0.0)) return bearing;
  return expSO3(-rowTime(v, height, readout_s) * rate_c) * bearing;
}

RowCamera::RowCamera(const Camera& camera, const RowExposure& rows)
    : camera_(camera), rows_(rows) {}

Eigen::Vector3d RowCamera::bearing(const Eigen::Vector2d& pixel) const {
  return rows_.atMiddleRow(camera_.bearing(pixel), pixel.y(), camera_.parameters().height);
}

bool RowCamera::project(const Eigen::Vector3d& direction, Eigen::Vector2d* pixel) const {
  if (!(rows_.readout_s > 0.0)) return camera_.project(direction, pixel);
  Eigen::Vector2d seen;
  if (!camera_.project(direction, &seen)) return false;
  for (int step = 0; step < kRowSteps; ++step) {
    if (!camera_.project(atOwnRow(direction, seen), &seen)) return false;
  }
  *pixel = seen;
  return true;
}

Eigen::Vector3d RowCamera::atOwnRow(const Eigen::Vector3d& direction,
                                    const Eigen::Vector2d& pixel) const {
  return rows_.atRow(direction, pixel.y(), camera_.parameters().height);
}

}  // namespace slim_init::feature_tracker_lines
