// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/row_motion.h"

#include <Eigen/Geometry>

namespace slim_init {
namespace {

// Rows of the residual that belong to image row `row`, and the derivatives by what its exposure
// adds.
template <typename View, typename Parameters, int D>
RowJacobian evaluateRow(const View& view, const Parameters& parameters, const RowExposure& at,
                        double row, double sqrt_information, ViewDerivatives<D>* out) {
  const Eigen::Vector3d v = at.state.v_b0.col(view.keyframe);
  const double dt = row * at.rows.readout_s;
  const CameraPlace place = {at.rows.t_b_c + dt * at.imu.rate.cross(at.rows.t_b_c), dt * v};
  evaluate(view, parameters, at.state, place, sqrt_information, out);
  RowJacobian by_row;
  const Eigen::Matrix<double, 2, 3> by_position = out->J_pose.template rightCols<3>();
  by_row.leftCols<3>() = dt * by_position;
  // A readout time longer by one second moves the exposure by the row's share of the image.
  by_row.col(3) = row * (out->J_pose.template leftCols<3>() * at.imu.rate + by_position * v);
  out->r += by_row.col(3) * at.state.rig.dreadout;
  return by_row;
}

}  // namespace

void evaluateAtRow(const PointView& view, const PointParameters& point, const RowExposure& at,
                   double sqrt_information, ViewDerivatives<3>* out, RowJacobian* by_row) {
  *by_row = evaluateRow(view, point, at, view.row, sqrt_information, out);
}

void evaluateAtRow(const LineView& view, const LineParameters& line, const RowExposure& at,
                   double sqrt_information, ViewDerivatives<4>* out, RowJacobian* by_row) {
  if (at.rows.readout_s == 0.0) {
    // One exposure: the derivative alone depends on the row.
    *by_row = evaluateRow(view, line, at, 1.0, sqrt_information, out);
    const Eigen::Vector2d row(view.start_row, view.end_row);
    out->r += (row.array() - 1.0).matrix().cwiseProduct(by_row->col(3)) * at.state.rig.dreadout;
    by_row->col(3) = by_row->col(3).cwiseProduct(row).eval();
    return;
  }
  // Each end point is a row of the residual, with an exposure of its own.
  ViewDerivatives<4> end;
  *by_row = evaluateRow(view, line, at, view.start_row, sqrt_information, out);
  by_row->row(1) = evaluateRow(view, line, at, view.end_row, sqrt_information, &end).row(1);
  out->r[1] = end.r[1];
  out->J_pose.row(1) = end.J_pose.row(1);
  out->J_track.row(1) = end.J_track.row(1);
}

}  // namespace slim_init
