// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Track ids of vanishing points (paper IV-B-1).
#include <cmath>

#include "geometry/units.h"
#include "imu/preintegration.h"
#include "lines/constants.h"
#include "lines/vanishing_point.h"

namespace slim_init {
namespace {

using namespace lines_constants;  // NOLINT: the constants of this module

// The axis nearest to `direction`, up to sign, that is within the threshold; -1 if none is.
int nearestAxis(const std::vector<Eigen::Vector3d>& axes_c0, const Eigen::Vector3d& direction_c0,
                double cos_threshold) {
  int nearest = -1;
  double largest_cosine = cos_threshold;
  for (std::size_t axis = 0; axis < axes_c0.size(); ++axis) {
    const double cosine = std::abs(axes_c0[axis].dot(direction_c0));
    if (cosine >= largest_cosine && (nearest < 0 || cosine > largest_cosine)) {
      nearest = static_cast<int>(axis);
      largest_cosine = cosine;
    }
  }
  return nearest;
}

}  // namespace

std::vector<VanishingPoint> trackVanishingPoints(const InitWindow& window,
                                                 const std::vector<Eigen::Matrix3d>& R_c0_ck,
                                                 const VanishingPointOptions& options) {
  std::vector<VanishingPoint> vps(static_cast<std::size_t>(window.size()));
  if (R_c0_ck.size() != vps.size()) return vps;
  const double sigma_line_rad = window.calibration().sigmaLine();
  const double cos_threshold = std::cos(options.match_threshold_deg / kDegPerRad);

  std::vector<Eigen::Vector3d> axes_c0;  // last observation of each id, the index being the id
  for (int k = 0; k < window.size(); ++k) {
    VanishingPoint& vp = vps[k];
    vp = estimateVanishingPoint(window.linesOfKeyframe(k), sigma_line_rad, options);
    if (!vp.found) continue;
    const Eigen::Vector3d direction_c0 = R_c0_ck[k] * vp.direction;

    // The axis of the keyframe before comes first: its prediction is the freshest.
    const int previous_id = k > 0 ? vps[k - 1].track_id : -1;
    if (previous_id >= 0 && std::abs(axes_c0[previous_id].dot(direction_c0)) >= cos_threshold) {
      vp.track_id = previous_id;
      vp.age = vps[k - 1].age + 1;
    } else {
      vp.track_id = nearestAxis(axes_c0, direction_c0, cos_threshold);
      vp.age = 1;
    }
    if (vp.track_id < 0) {
      vp.track_id = static_cast<int>(axes_c0.size());
      axes_c0.push_back(direction_c0);
    } else {
      axes_c0[vp.track_id] = direction_c0;
    }
  }
  return vps;
}

std::vector<VanishingPoint> trackVanishingPoints(const InitWindow& window,
                                                 const VanishingPointOptions& options) {
  const std::vector<Preintegration> predicted = preintegrateWindow(
      window, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), PreintegrationParts::kRotation);
  return trackVanishingPoints(
      window, cameraRotations(chainRotations(predicted), window.calibration().R_b_c), options);
}

}  // namespace slim_init
