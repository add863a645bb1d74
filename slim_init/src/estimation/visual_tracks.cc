// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/visual_tracks.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "geometry/so3.h"

namespace slim_init {

PointParameters PointParameters::moved(const Eigen::Vector3d& step) const {
  PointParameters out = *this;
  out.direction = (direction + tangent * step.head<2>()).normalized();
  out.tangent = tangentBasis(out.direction);
  out.inverse_depth += step[2];
  return out;
}

void evaluate(const PointView& view, const PointParameters& point, const WindowState& state,
              const CameraPlace& camera, double sqrt_information, ViewDerivatives<3>* out) {
  const Eigen::Matrix3d& R = state.R_b0_bk[view.keyframe];
  const double rho = point.inverse_depth;
  const Eigen::Vector3d from_body = point.origin - (state.p_b0.col(view.keyframe) + camera.moved);
  const Eigen::Vector3d z = R.transpose() * (point.direction + rho * from_body);
  const Eigen::Vector3d y = z - rho * camera.t_b_c;
  const double inverse_norm = 1.0 / y.norm();
  const Eigen::Vector3d u = y * inverse_norm;
  const Eigen::Vector2d across = view.tangent_b * u;
  out->r = sqrt_information * across;
  const Eigen::Matrix<double, 2, 3> dr_dy =
      (sqrt_information * inverse_norm) * (view.tangent_b - across * u.transpose());
  // y x theta + rho t x theta = z x theta
  out->J_pose.leftCols<3>().row(0) = dr_dy.row(0).transpose().cross(z).transpose();
  out->J_pose.leftCols<3>().row(1) = dr_dy.row(1).transpose().cross(z).transpose();
  const Eigen::Matrix<double, 2, 3> dr_dx = dr_dy * R.transpose();
  out->J_pose.rightCols<3>() = -rho * dr_dx;
  out->J_track.leftCols<2>() = dr_dx * point.tangent;
  out->J_track.col(2) = dr_dy * (R.transpose() * from_body - camera.t_b_c);
}

PointParameters triangulate(const PointView* views, int count, const WindowState& state,
                            const Eigen::Vector3d& t_b_c) {
  PointParameters point;
  // The ray of the view in the middle: nearest to all others, and neither end of a drifting track.
  const PointView& middle = views[count / 2];
  point.origin = cameraCentre(state, middle.keyframe, t_b_c);
  point.direction = state.R_b0_bk[middle.keyframe] * middle.bearing_b;
  point.tangent = tangentBasis(point.direction);
  // u_k x (d + rho (o - c_k)) = 0, linear in rho.
  double a = 0.0, b = 0.0;
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d u = state.R_b0_bk[views[k].keyframe] * views[k].bearing_b;
    const Eigen::Vector3d slope =
        u.cross(point.origin - cameraCentre(state, views[k].keyframe, t_b_c));
    a += slope.squaredNorm();
    b -= slope.dot(u.cross(point.direction));
  }
  point.inverse_depth = a > 0.0 ? std::clamp(b / a, 0.0, kMaxStartInverseDistance) : 0.0;
  return point;
}

namespace {

// Rows of the residual that belong to image row `row`, and the derivatives by what its exposure
// adds.
template <typename View, typename Parameters, int D>
RowJacobian evaluateRow(const View& view, const Parameters& parameters, const RowExposure& at,
                        double row, double sqrt_information, ViewDerivatives<D>* out) {
  const Eigen::Vector3d v = at.state.v_b0.col(view.keyframe);
  const double dt = row * at.readout_s;
  const CameraPlace place = {at.t_b_c + dt * at.imu.rate.cross(at.t_b_c), dt * v};
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
  if (at.readout_s == 0.0) {
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
