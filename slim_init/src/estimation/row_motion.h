// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rolling shutter in the estimation (docs/derivation.md, 4.11): the rotation between the exposures
// of row and keyframe has been taken off the bearings (withRowsCompensated()); what remains is the
// way of the camera in between, v dt, its lever arm, and an error of the readout time.
#pragma once

#include <Eigen/Core>

#include "estimation/rig_model.h"
#include "estimation/visual_tracks.h"
#include "imu/window_state.h"
#include "lines/line_track.h"

namespace slim_init {

/// Derivative of one residual by what a row's exposure adds to its keyframe: velocity (3) of the
/// keyframe, readout time.
constexpr int kRowMotion = 4;
using RowJacobian = Eigen::Matrix<double, 2, kRowMotion>;

/// What all views of a window share.
struct RowMotion {
  Eigen::Vector3d t_b_c;   ///< of the calibration
  double readout_s = 0.0;  ///< of the calibration; zero: a global shutter
};

/// Where the views of one keyframe are evaluated.
struct RowExposure {
  const WindowState& state;
  const RowMotion& rows;
  const ImuInstant& imu;  ///< motion at the keyframe
};

/// evaluate() at the exposure of the view's own row (of both, for a line), at the state's readout
/// time, with the derivatives by velocity and readout time.
void evaluateAtRow(const PointView& view, const PointParameters& point, const RowExposure& at,
                   double sqrt_information, ViewDerivatives<3>* out, RowJacobian* by_row);
void evaluateAtRow(const LineView& view, const LineParameters& line, const RowExposure& at,
                   double sqrt_information, ViewDerivatives<4>* out, RowJacobian* by_row);

}  // namespace slim_init
