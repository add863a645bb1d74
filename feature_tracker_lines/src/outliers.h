// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Which pairs of rays of two images do not belong to a rigid scene.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slim_init::feature_tracker_lines {

/// Result of knownRotationInliers().
struct EpipoleFit {
  std::vector<unsigned char> flags;                   ///< one per pair, 1 for an inlier
  Eigen::Vector3d epipole = Eigen::Vector3d::Zero();  ///< unit, sign arbitrary; zero: not found
};

/// Two-point RANSAC with known rotation: two pairs give the direction of the translation,
/// e = m_1 x m_2 with m = (R f_before) x f_now; the winner (lowest sum of truncated distances) is
/// polished by re-weighted least squares. All rays unit; the distance of a pair to its epipolar
/// plane is to first order (Sampson) and in pixels at the image centre, `focal_px` per radian.
///
/// Without translation every pair that moved by less than the threshold is an inlier. Fewer than
/// three pairs: all are inliers. Deterministic.
EpipoleFit knownRotationInliers(const std::vector<Eigen::Vector3d>& rotated_before,
                                const std::vector<Eigen::Vector3d>& now, double focal_px,
                                double threshold_px);

/// Three views with known rotations, all rays unit and rotated into one orientation. The first two
/// views give each point's distance, the first and the third give it again, and the ratio of the
/// two translations' lengths is the same for all points. A track that drifts along its epipolar
/// line, as on shading or where one edge crosses another one behind it, passes every check of two
/// views and fails this one.
///
/// Returns one flag per point, 1 for an inlier: both epipolar distances within `threshold_px`, and
/// the difference along the epipolar line, divided by what equal image errors make of it, within
/// three times the robust standard deviation of all of them, `least_px` at least and `threshold_px`
/// at most.
/// All are inliers where there is too little translation to tell: fewer than eight points with more
/// than two pixels of parallax in both pairs.
std::vector<unsigned char> threeViewInliers(const std::vector<Eigen::Vector3d>& first,
                                            const std::vector<Eigen::Vector3d>& second,
                                            const std::vector<Eigen::Vector3d>& third,
                                            double focal_px, double threshold_px, double least_px);

/// Fundamental-matrix RANSAC (OpenCV) on the plane z = 1 times `focal_px`. Pairs with a ray more
/// than 75 degrees off the axis, which that plane does not hold well, are not checked and count as
/// inliers. Fewer than eight pairs to check: all are inliers.
std::vector<unsigned char> fundamentalInliers(const std::vector<Eigen::Vector3d>& before,
                                              const std::vector<Eigen::Vector3d>& now,
                                              double focal_px, double threshold_px);

}  // namespace slim_init::feature_tracker_lines
