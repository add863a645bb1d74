// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A line track with the four parameters of its line. The refinement eliminates them inside every
// Gauss-Newton step; line agreement fits them to a known motion (docs/derivation.md, 4.4 and 4.8).
//
// Camera k has its centre at c_k = p_k + R_k t_b_c with R_k = R_b0_bk; bearings are kept in the
// body frame (f_b = R_b_c f_c), so that the extrinsic rotation is applied once.
#pragma once

#include <Eigen/Core>

#include "geometry/view_derivatives.h"
#include "imu/window_state.h"

namespace slim_init {

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

}  // namespace slim_init
