// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Dominant vanishing point of each keyframe and its track through the window (paper IV-B-1,
// IV-B-2).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slim_init/init_window.h"
#include "slim_init/options.h"

namespace slim_init {

/// Dominant vanishing direction of one keyframe.
struct VanishingPoint {
  bool found = false;
  /// Unit, in c, front hemisphere (z >= 0). A vanishing direction has no sense: between keyframes
  /// the sign flips when the axis crosses z = 0; two directions are to be compared up to sign.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  /// Covariance of the direction, rank 2 (across the direction), in c [rad^2].
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<int> inliers;  ///< indices into the lines handed to the estimator, ascending
  int track_id = -1;         ///< same id = same physical axis; -1: not found or not tracked
  int age = 0;               ///< consecutive keyframes with this id, this one included
};

/// Vote and refine for one keyframe (paper IV-B-1). Every line votes with its length for every
/// direction with |n . d| < sin(vote_threshold); of those in which two of the longest lines meet
/// (the paper's are a grid, an icosphere) the most voted one wins. A weighted least squares fit
/// over its voters, weights = lengths, eq. (2), then selection of the inliers |n . d| < sin(t_in)
/// and fit over them in turn until the set repeats itself (at most four times). Lines with
/// length_px <= 0 take no part. The answer does not depend on the order of lines.
///
/// `sigma_line_rad` [rad] is the standard deviation of a line end point across the line; it scales
/// the covariance, which propagates it to first order through the fit (A^+ B A^+, since length
/// weights are not inverse variances). Clutter, distortion and lines that are not quite parallel
/// are not in it.
///
/// found == false for fewer than min_inliers lines, and for a bundle of near-parallel image lines
/// whose planes differ too little to say where along them the direction is (kMinDetermination).
/// track_id and age are left to trackVanishingPoints.
VanishingPoint estimateVanishingPoint(const std::vector<WindowLine>& lines, double sigma_line_rad,
                                      const VanishingPointOptions& options);

/// Estimates every keyframe's vanishing point and carries track ids from keyframe to keyframe with
/// `R_c0_ck` (rotation of camera k into camera 0, from the gyro). A vanishing point gets the id of
/// the nearest axis seen before within match_threshold_deg of it (up to sign), and ages where the
/// keyframe before has that id; a new axis gets a new id. Ids count from 0 in order of appearance.
/// One entry per keyframe; none found if `R_c0_ck` has another size than the window.
///
/// An axis is remembered as its last observation rotated into camera 0, not as a mean or as the
/// first: with a gyro bias still unknown the predicted rotation drifts (0.1 rad/s over a window of
/// 2.25 s is 13 deg), and only the part since the last observation must stay within the threshold.
std::vector<VanishingPoint> trackVanishingPoints(const InitWindow& window,
                                                 const std::vector<Eigen::Matrix3d>& R_c0_ck,
                                                 const VanishingPointOptions& options);

/// The same with the rotations of the gyroscope as it is: over one keyframe gap an unknown bias
/// turns the camera by less than the matching threshold.
std::vector<VanishingPoint> trackVanishingPoints(const InitWindow& window,
                                                 const VanishingPointOptions& options);

}  // namespace slim_init
