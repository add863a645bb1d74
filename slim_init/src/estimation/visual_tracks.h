// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Point tracks of the refinement; those of lines are in lines/line_track.h. Each track has a few
// parameters of its own (3 and 4) that are eliminated inside every Gauss-Newton step; they are
// scratch of the solver and never leave it.
//
// Camera k sees along R_k^T (x - c_k) with R_k = R_b0_bk and c_k = p_k + R_k t_b_c; bearings are
// kept in the body frame (f_b = R_b_c f_c), so that the extrinsic rotation is applied once.
#pragma once

#include <Eigen/Core>

#include "estimation/inertial_factor.h"
#include "imu/window_state.h"
#include "lines/line_track.h"

namespace slim_init {

/// A point seen in keyframe k.
struct PointView {
  int keyframe = 0;
  Eigen::Vector3d bearing_b;
  Eigen::Matrix<double, 2, 3> tangent_b;  ///< two directions across the bearing, rows, in b
  double row = 0.0;                       ///< PointObservation::row
};

/// A point as origin, unit direction and inverse depth: x = origin + direction / inverse_depth,
/// a bearing where inverse_depth is zero. The origin is a constant of the parameters, not a state.
/// A negative inverse depth is the smooth continuation through infinity; noise of a far point puts
/// it there, and cutting it off would bias the baseline.
struct PointParameters {
  Eigen::Vector3d origin;     ///< in b0 [m]
  Eigen::Vector3d direction;  ///< unit, in b0
  Eigen::Matrix<double, 3, 2> tangent;
  double inverse_depth = 0.0;  ///< [1/m]

  PointParameters moved(const Eigen::Vector3d& step) const;
};

/// Residuals of one view, the components of the predicted bearing across the observed one, and
/// their derivatives. `sqrt_information` is 1 / sigma [1/rad].
void evaluate(const PointView& view, const PointParameters& point, const WindowState& state,
              const CameraPlace& camera, double sqrt_information, ViewDerivatives<3>* out);

/// Starting parameters of a track from the state, by linear least squares with the known camera
/// motion. `views` has at least two entries.
PointParameters triangulate(const PointView* views, int count, const WindowState& state,
                            const Eigen::Vector3d& t_b_c);

// Rolling shutter (docs/derivation.md, 4.11): the rotation between the exposures of row and
// keyframe has been taken off the bearings (withRowsCompensated()); what remains is the way of the
// camera in between, v dt, its lever arm, and an error of the readout time.

/// Derivative of one residual by what a row's exposure adds to its keyframe: velocity (3) of the
/// keyframe, readout time.
using RowJacobian = Eigen::Matrix<double, 2, 4>;

/// Where the views of one keyframe are evaluated.
struct RowExposure {
  const WindowState& state;
  const Eigen::Vector3d& t_b_c;  ///< of the calibration
  double readout_s;              ///< of the calibration; zero: a global shutter
  const ImuInstant& imu;         ///< motion at the keyframe
};

/// evaluate() at the exposure of the view's own row (of both, for a line), at the state's readout
/// time, with the derivatives by velocity and readout time.
void evaluateAtRow(const PointView& view, const PointParameters& point, const RowExposure& at,
                   double sqrt_information, ViewDerivatives<3>* out, RowJacobian* by_row);
void evaluateAtRow(const LineView& view, const LineParameters& line, const RowExposure& at,
                   double sqrt_information, ViewDerivatives<4>* out, RowJacobian* by_row);

}  // namespace slim_init
