// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/row_motion.h"

#include <Eigen/Geometry>

namespace slim_init {
namespace {

// Rows of the residual that belong to image row `row`.
template <typename View, typename Parameters, int D>
void evaluateRow(const View& view, const Parameters& parameters, const WindowState& state,
                 const RowMotion& rows, const ImuInstant& imu, double row, double sqrt_information,
                 ViewDerivatives<D>* out, RowJacobian* by_row) {
  const Eigen::Vector3d v = state.v_b0.col(view.keyframe);
  const double dt = row * rows.readout_s;
  const Eigen::Vector3d lever = rows.t_b_c + dt * imu.rate.cross(rows.t_b_c);
  evaluate(view, parameters, state, lever, sqrt_information, out, dt * v);
  const Eigen::Matrix<double, 2, 3> by_position = out->J_pose.template rightCols<3>();
  by_row->leftCols<3>() = dt * by_position;
  // A readout time longer by one second moves the exposure by the row's share of the image.
  by_row->col(3) = row * (out->J_pose.template leftCols<3>() * imu.rate + by_position * v);
  out->r += by_row->col(3) * state.rig.dreadout;
}

}  // namespace

void evaluateAtRow(const PointView& view, const PointParameters& point, const WindowState& state,
                   const RowMotion& rows, const ImuInstant& imu, double sqrt_information,
                   ViewDerivatives<3>* out, RowJacobian* by_row) {
  evaluateRow(view, point, state, rows, imu, view.row, sqrt_information, out, by_row);
}

void evaluateAtRow(const LineView& view, const LineParameters& line, const WindowState& state,
                   const RowMotion& rows, const ImuInstant& imu, double sqrt_information,
                   ViewDerivatives<4>* out, RowJacobian* by_row) {
  if (rows.readout_s == 0.0) {
    // One exposure: the derivative alone depends on the row.
    evaluateRow(view, line, state, rows, imu, 1.0, sqrt_information, out, by_row);
    const Eigen::Vector2d row(view.start_row, view.end_row);
    out->r += (row.array() - 1.0).matrix().cwiseProduct(by_row->col(3)) * state.rig.dreadout;
    by_row->col(3) = by_row->col(3).cwiseProduct(row).eval();
    return;
  }
  // Each end point is a row of the residual, with an exposure of its own.
  ViewDerivatives<4> end;
  RowJacobian end_by_row;
  evaluateRow(view, line, state, rows, imu, view.start_row, sqrt_information, out, by_row);
  evaluateRow(view, line, state, rows, imu, view.end_row, sqrt_information, &end, &end_by_row);
  out->r[1] = end.r[1];
  out->J_pose.row(1) = end.J_pose.row(1);
  out->J_track.row(1) = end.J_track.row(1);
  by_row->row(1) = end_by_row.row(1);
}

void evaluateAtRow(const DirectionView& view, const DirectionParameters& axis,
                   const WindowState& state, const RowMotion& rows, const ImuInstant& /*imu*/,
                   double sqrt_information, ViewDerivatives<2>* out, RowJacobian* by_row) {
  evaluate(view, axis, state, rows.t_b_c, sqrt_information, out);
  by_row->setZero();
}

}  // namespace slim_init
