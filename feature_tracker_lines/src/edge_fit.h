// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A straight 3D edge in a distorted image, to a fraction of a pixel.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "row_camera.h"

namespace slim_init::feature_tracker_lines {

/// A plane through the camera centre with two ends, parametrised from its middle: directions u + x
/// t on it, and u + x t + y n beside it. `start` and `end` are unit and less than 150 degrees
/// apart.
struct ArcFrame {
  ArcFrame(const Eigen::Vector3d& start, const Eigen::Vector3d& end);

  double alongOf(const Eigen::Vector3d& f) const { return f.dot(t) / f.dot(u); }   ///< x
  double acrossOf(const Eigen::Vector3d& f) const { return f.dot(n) / f.dot(u); }  ///< y
  Eigen::Vector3d direction(double x, double y) const { return (u + x * t + y * n).normalized(); }

  Eigen::Vector3d u, t, n;
  double x_start = 0.0, x_end = 0.0;
};

/// Robust straight line y = offset + slope x by Cauchy re-weighted least squares.
struct StraightFit {
  bool ok = false;
  double offset = 0.0, slope = 0.0;
};
StraightFit fitStraight(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y, double scale);

/// An edge with the brighter side at n = start x end (right of start to end as seen).
struct Edge {
  Eigen::Vector3d start = Eigen::Vector3d::UnitZ();  ///< unit, at the middle row, on the fit
  Eigen::Vector3d end = Eigen::Vector3d::UnitZ();
  Eigen::Vector2d start_pixel = Eigen::Vector2d::Zero();  ///< raw
  Eigen::Vector2d end_pixel = Eigen::Vector2d::Zero();
  double length_px = 0.0;  ///< between the raw end points
  double rms_px = 0.0;     ///< of the edge samples used, about the fit, at the image centre's scale
  double support = 0.0;    ///< share of the samples along it that are used
  double contrast = 0.0;   ///< median slope of the brightness across [grey levels / px]

  /// Unit normal of the interpretation plane; the brighter side.
  Eigen::Vector3d normal() const;
};

/// Fits an edge near the arc from `start` to `end`: samples along the arc, each moved across it by
/// up to `search_px` to the steepest rise in brightness (parabola through the slope), and a robust
/// line through their undistorted positions. The ends are cut back to the longest stretch with
/// edge. All rays are those of the middle row's exposure. `grey` CV_8UC1, `noise` its pixel noise
/// [grey levels]. False where there is no such edge: fewer than five samples, less than
/// `min_support` of them used, or an rms above `max_rms_px`.
bool fitEdge(const cv::Mat& grey, const RowCamera& camera, const Eigen::Vector3d& start,
             const Eigen::Vector3d& end, double search_px, double noise, double min_support,
             double max_rms_px, Edge* edge);

}  // namespace slim_init::feature_tracker_lines
