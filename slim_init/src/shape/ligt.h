// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Step 2a: camera positions up to scale from known rotations, without any 3D point (LiGT, Cai et
// al., "A Pose-only Solution to Visual Reconstruction and Navigation", 2021).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "slim_init/init_window.h"
#include "slim_init/options.h"

namespace slim_init {

/// Up-to-scale camera positions with what they rest on.
struct TranslationEstimate {
  bool valid = false;  ///< enough tracks and a finite solution
  /// Camera centres (3xN) in the frame of the first camera, column 0 zero, scaled to unit spread
  /// (root of the summed squared distances from their mean).
  Eigen::Matrix3Xd centres_c0;
  int tracks = 0;           ///< tracks used
  int rows = 0;             ///< scalar equations
  double lambda_1 = 0.0;    ///< smallest eigenvalue of the system
  double lambda_2 = 0.0;    ///< second smallest
  double lambda_max = 0.0;  ///< largest
  /// Normal matrix L^T L of the rows over all stacked centres (3N x 3N), symmetric, in the frame of
  /// the first camera. Its null space holds the common translations.
  Eigen::MatrixXd normal_matrix;
  /// lambda_1, or its rounding error: without noise it vanishes.
  double noise() const { return std::max(lambda_1, 1e-16 * lambda_max); }
  /// Below about 10 the tracks do not link the window.
  double linkage() const { return lambda_2 / noise(); }
};

/// The two views of a track with the largest parallax, rotation taken out.
struct BaseViews {
  int l = 0, r = 0;         ///< indices into the views, l < r
  double parallax2 = -1.0;  ///< |u_l x u_r|^2; below zero with fewer than two views
};
/// `u`: unit vectors in a common frame, the bearings of a point.
BaseViews chooseBaseViews(const std::vector<Eigen::Vector3d>& u);

/// The 3x(3N) rows of one observation: L c = 0 for the camera centres c (stacked 3N).
///
/// With bearings u in the common frame, base views l and r, theta = u_l x u_r:
///   depth of the point in l times |theta|^2 = theta . ((c_r - c_l) x u_r),
///   u_i x (c_l + depth u_l - c_i) = 0.
/// Only the blocks of r, l and i are non-zero; they are returned in that order.
struct LigtRow {
  Eigen::Matrix3d block_r, block_l, block_i;
};
LigtRow ligtRow(const Eigen::Vector3d& u_l, const Eigen::Vector3d& u_r, const Eigen::Vector3d& u_i);

/// Keyframes of a track: two views do not determine the relative scale.
inline constexpr int kMinTrackLength = 3;
/// Tracks of that length with that parallax that a solution needs.
inline constexpr int kMinTracks = 8;

/// Solves for the camera centres. `R_c0_ck`: rotation of camera k into the first camera, one per
/// keyframe. Tracks seen in fewer than kMinTrackLength keyframes or with less parallax than
/// kSmallestAngle are left out; with fewer than kMinTracks left, valid == false.
TranslationEstimate estimateTranslations(const InitWindow& window,
                                         const std::vector<Eigen::Matrix3d>& R_c0_ck);

/// How much a track counts, by how far it is from `centres` (stacked 3N; empty: all count the
/// same): its cost is linear beyond `sigma`, standard deviation of a bearing [rad].
struct LengthWeights {
  Eigen::VectorXd centres;
  double sigma = 1.0;
};

/// The normal matrix of the same rows, each divided by |theta|^2: then they are the distances by
/// which the lines of sight miss the points, for points at unit distance and centres of any size.
Eigen::MatrixXd lengthNormalMatrix(const InitWindow& window,
                                   const std::vector<Eigen::Matrix3d>& R_c0_ck,
                                   const LengthWeights& weights);

}  // namespace slim_init
