// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A line track with the four parameters of its line. The refinement eliminates them inside every
// Gauss-Newton step; line agreement fits them to a known motion (docs/derivation.md, 4.4 and 4.8).
//
// Camera k has its centre at c_k = p_k + R_k t_b_c with R_k = R_b0_bk; bearings are kept in the
// body frame (f_b = R_b_c f_c), so that the extrinsic rotation is applied once.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "imu/window_state.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// Keyframes of a line: two views do not constrain the motion.
inline constexpr int kMinLineViews = 3;

/// Nearest point or line that a start may have [1/m]; nearer ones are wrong matches.
inline constexpr double kMaxStartInverseDistance = 10.0;

/// Derivatives of one view of a track: two residuals, whitened.
template <int D>
struct ViewDerivatives {
  Eigen::Vector2d r;
  Eigen::Matrix<double, 2, 6> J_pose;  ///< against [theta_k, p_k]
  Eigen::Matrix<double, 2, D> J_track;
};

/// Where the camera is at an exposure, seen from the body at its keyframe.
struct CameraPlace {
  // NOLINTNEXTLINE: mostly the lever arm is all.
  CameraPlace(const Eigen::Vector3d& lever, const Eigen::Vector3d& way = Eigen::Vector3d::Zero())
      : t_b_c(lever), moved(way) {}

  Eigen::Vector3d t_b_c;  ///< in the body [m]
  Eigen::Vector3d moved;  ///< of the body from the keyframe to the exposure, in b0 [m]
};

/// A line segment seen in keyframe k.
struct LineView {
  int keyframe = 0;
  Eigen::Vector3d start_b, end_b;
  double start_row = 0.0;  ///< LineObservation::start_row
  double end_row = 0.0;
};

/// A line as origin, orthonormal frame and inverse distance. Columns of `frame`: direction q from
/// the origin to the foot of the line, direction D of the line, normal w = q x D of the plane
/// through the origin. The plane through camera centre c has the normal
/// w + inverse_distance (origin - c) x D: at zero the same for every camera, a line at infinity.
struct LineParameters {
  Eigen::Vector3d origin;         ///< in b0 [m]
  Eigen::Matrix3d frame;          ///< in b0
  double inverse_distance = 0.0;  ///< [1/m]

  LineParameters moved(const Eigen::Vector4d& step) const;
};

/// Sines of the angles of both end points to the predicted plane, times `sqrt_information`
/// (1 / sigma [1/rad]), and their derivatives.
void evaluate(const LineView& view, const LineParameters& line, const WindowState& state,
              const CameraPlace& camera, double sqrt_information, ViewDerivatives<4>* out);

/// Starting parameters of a track from the state, by linear least squares with the known camera
/// motion. `views` has at least two entries. Planes that are parallel to within noise put the line
/// at infinity; false where the middle view has no plane.
bool triangulate(const LineView* views, int count, const WindowState& state,
                 const Eigen::Vector3d& t_b_c, LineParameters* line);

/// A line that the tracker confuses with another stays confused for the rest of its track; a robust
/// loss alone does not help against it, since with a jump in the middle neither half is the
/// outlier. Line tracks cut into stretches of consecutive observations in which a single line
/// explains every end point to within `max_error_rad`, seen from the cameras of `motion`; the
/// longest stretch first, then what is left on both sides of it. Stretches shorter than `min_views`
/// are left out.
///
/// Only rotations and the shape of the trajectory matter, not its scale. Two views always agree
/// (they put no constraint on the motion, docs/derivation.md), so the test begins with the third.
/// Returned are ranges of InitWindow::lineObservations(); ids repeat after a cut.
std::vector<Track> agreeingLineTracks(const InitWindow& window, const WindowState& motion,
                                      double max_error_rad, int min_views);

}  // namespace slim_init
