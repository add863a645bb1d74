// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "rotation_prior.h"
#include "slim_init/feature_tracker_lines/camera.h"

namespace slim_init::feature_tracker_lines {

/// The camera of one image whose rows are exposed one after the other: its rays are those of the
/// middle row's exposure, as if all rows had been exposed then (of points far away; the way of the
/// camera during the readout is left out). So a straight edge is a plane, whatever the camera's
/// turn makes of it in the image. A global shutter: the camera itself.
class RowCamera {
 public:
  explicit RowCamera(const Camera& camera, const RowExposure& rows = RowExposure());

  /// Unit ray at the middle row through a raw pixel; all NaN where the lens has none.
  Eigen::Vector3d bearing(const Eigen::Vector2d& pixel) const;

  /// Raw pixel at which a direction of the middle row's exposure (any length) is seen, in the row
  /// that is exposed when it is there. False, and `pixel` unchanged, where the lens does not see
  /// it.
  bool project(const Eigen::Vector3d& direction, Eigen::Vector2d* pixel) const;

  /// The ray of the pixel's own row, as it is observed, for one at the middle row.
  Eigen::Vector3d atOwnRow(const Eigen::Vector3d& direction, const Eigen::Vector2d& pixel) const;

  double focalPx() const { return camera_.focalPx(); }

 private:
  Camera camera_;
  RowExposure rows_;
};

}  // namespace slim_init::feature_tracker_lines
