// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slim_init/feature_tracker_lines/camera.h"

namespace slim_init::feature_tracker_lines {

/// Rows of one image that are exposed one after the other, while the camera turns.
struct RowExposure {
  double readout_s = 0.0;  ///< Calibration::readout_s; 0: all rows at once
  /// Angular rate of the camera in its own frame when its middle row is exposed [rad/s].
  Eigen::Vector3d rate_c = Eigen::Vector3d::Zero();
};

/// Prior knowledge of the camera's rotation since the previous image.
struct RotationPrior {
  double dt_s = 0.0;  ///< since the previous image [s]
  /// dt_s over the interval before it: what moved evenly moves so many times as far.
  double dt_ratio = 1.0;
  /// By the gyroscope. False: the rotation below is the identity, after PointTracker::follow() the
  /// turn that the tracks agree with best; how well is not known.
  bool measured = false;
  /// Maps directions in the camera at the previous image to the camera now, middle row to middle
  /// row.
  Eigen::Matrix3d R_now_before = Eigen::Matrix3d::Identity();
  bool known = false;                     ///< measured, and corrected for the bias of the gyroscope
  RowExposure rows_before{}, rows_now{};  ///< of the two images; at rest where nothing is measured
};

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

  /// The ray of row `v`, as it is observed, for one at the middle row: Exp(rate_c dt)^-1 f.
  Eigen::Vector3d atOwnRow(const Eigen::Vector3d& direction, double v) const;
  /// The other way round.
  Eigen::Vector3d atMiddleRow(const Eigen::Vector3d& direction, double v) const;

  double focalPx() const { return camera_.focalPx(); }

 private:
  Camera camera_;
  RowExposure rows_;
};

}  // namespace slim_init::feature_tracker_lines
