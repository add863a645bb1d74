// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/visual_tracks.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/so3.h"

namespace slim_init {
namespace {

// Nearest point that a start may have; nearer ones are wrong matches [1/m].
constexpr double kMaxStartInverseDepth = 10.0;

Eigen::Vector3d cameraCentre(const WindowState& state, int k, const Eigen::Vector3d& t_b_c) {
  return state.p_b0.col(k) + state.R_b0_bk[k] * t_b_c;
}

}  // namespace

PointParameters PointParameters::moved(const Eigen::Vector3d& step) const {
  PointParameters out = *this;
  out.direction = (direction + tangent * step.head<2>()).normalized();
  out.tangent = tangentBasis(out.direction);
  out.inverse_depth += step[2];
  return out;
}

LineParameters LineParameters::moved(const Eigen::Vector4d& step) const {
  LineParameters out = *this;
  out.frame = expSO3(step.head<3>()) * frame;
  out.inverse_distance += step[3];
  return out;
}

DirectionParameters DirectionParameters::moved(const Eigen::Vector2d& step) const {
  DirectionParameters out;
  out.direction = (direction + tangent * step).normalized();
  out.tangent = tangentBasis(out.direction);
  return out;
}

void evaluate(const PointView& view, const PointParameters& point, const WindowState& state,
              const Eigen::Vector3d& t_b_c, double sqrt_information, ViewDerivatives<3>* out) {
  const Eigen::Matrix3d& R = state.R_b0_bk[view.keyframe];
  const double rho = point.inverse_depth;
  const Eigen::Vector3d from_body = point.origin - state.p_b0.col(view.keyframe);
  const Eigen::Vector3d z = R.transpose() * (point.direction + rho * from_body);
  const Eigen::Vector3d y = z - rho * t_b_c;
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
  out->J_track.col(2) = dr_dy * (R.transpose() * from_body - t_b_c);
}

void evaluate(const LineView& view, const LineParameters& line, const WindowState& state,
              const Eigen::Vector3d& t_b_c, double sqrt_information, ViewDerivatives<4>* out) {
  const Eigen::Matrix3d& R = state.R_b0_bk[view.keyframe];
  const double rho = line.inverse_distance;
  const Eigen::Vector3d D = line.frame.col(1);
  const Eigen::Vector3d w = line.frame.col(2);
  const Eigen::Vector3d from_camera = line.origin - cameraCentre(state, view.keyframe, t_b_c);
  const Eigen::Vector3d n = w + rho * from_camera.cross(D);
  const double inverse_norm = 1.0 / n.norm();
  const Eigen::Vector3d n_b = R.transpose() * n;
  const Eigen::Vector3d unit = n_b * inverse_norm;
  const Eigen::Vector3d D_b = R.transpose() * D;

  const Eigen::Matrix3d dn_dtheta = skew(n_b) - rho * skew(D_b) * skew(t_b_c);
  const Eigen::Matrix3d dn_dp = rho * skew(D);  // in b0
  const Eigen::Matrix3d dn_dframe = -skew(w) - rho * skew(from_camera) * skew(D);
  const Eigen::Vector3d dn_drho = from_camera.cross(D);

  const Eigen::Vector3d* ends[2] = {&view.start_b, &view.end_b};
  for (int e = 0; e < 2; ++e) {
    const double sine = ends[e]->dot(unit);
    out->r[e] = sqrt_information * sine;
    const Eigen::Vector3d dr_dn_b = (sqrt_information * inverse_norm) * (*ends[e] - sine * unit);
    const Eigen::Vector3d dr_dn = R * dr_dn_b;
    out->J_pose.row(e).head<3>() = dr_dn_b.transpose() * dn_dtheta;
    out->J_pose.row(e).tail<3>() = dr_dn.transpose() * dn_dp;
    out->J_track.row(e).head<3>() = dr_dn.transpose() * dn_dframe;
    out->J_track(e, 3) = dr_dn.dot(dn_drho);
  }
}

void evaluate(const DirectionView& view, const DirectionParameters& axis, const WindowState& state,
              const Eigen::Vector3d& /*t_b_c*/, double sqrt_information, ViewDerivatives<2>* out) {
  const Eigen::Matrix3d& R = state.R_b0_bk[view.keyframe];
  const Eigen::Vector3d d_b = R.transpose() * axis.direction;
  const Eigen::Matrix<double, 2, 3> G = sqrt_information * view.whitened_tangent_b;
  out->r = G * d_b;
  out->J_pose.leftCols<3>() = G * skew(d_b);
  out->J_pose.rightCols<3>().setZero();
  out->J_track = G * R.transpose() * axis.tangent;
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
  point.inverse_depth = a > 0.0 ? std::clamp(b / a, 0.0, kMaxStartInverseDepth) : 0.0;
  return point;
}

bool triangulate(const LineView* views, int count, const WindowState& state,
                 const Eigen::Vector3d& t_b_c, LineParameters* line) {
  const LineView& middle = views[count / 2];
  line->origin = cameraCentre(state, middle.keyframe, t_b_c);
  const Eigen::Matrix3d& R_middle = state.R_b0_bk[middle.keyframe];
  const Eigen::Vector3d w = (R_middle * middle.start_b.cross(middle.end_b)).normalized();
  if (!(w.squaredNorm() > 0.5)) return false;  // zero, or not a number
  // The direction lies in the plane of the middle view and in all others: the least-squares null
  // direction of their normals, which are as long as the segments' angles and so weigh by them.
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d n =
        state.R_b0_bk[views[k].keyframe] * views[k].start_b.cross(views[k].end_b);
    normals += n * n.transpose();
  }
  const Eigen::Matrix<double, 3, 2> plane = tangentBasis(w);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(plane.transpose() * normals * plane);
  const Eigen::Vector3d D = plane * solver.eigenvectors().col(0);
  line->frame.col(0) = D.cross(w);
  line->frame.col(1) = D;
  line->frame.col(2) = w;
  // Both end points of each view lie in its plane: e_k . (w + rho (o - c_k) x D) = 0.
  double a = 0.0, b = 0.0;
  for (int k = 0; k < count; ++k) {
    const Eigen::Matrix3d& R = state.R_b0_bk[views[k].keyframe];
    const Eigen::Vector3d slope =
        (line->origin - cameraCentre(state, views[k].keyframe, t_b_c)).cross(D);
    for (const Eigen::Vector3d* end : {&views[k].start_b, &views[k].end_b}) {
      const Eigen::Vector3d e = R * *end;
      a += e.dot(slope) * e.dot(slope);
      b -= e.dot(slope) * e.dot(w);
    }
  }
  line->inverse_distance =
      a > 0.0 ? std::clamp(b / a, -kMaxStartInverseDepth, kMaxStartInverseDepth) : 0.0;
  return true;
}

DirectionParameters meanDirection(const DirectionView* views, int count, const WindowState& state) {
  DirectionParameters axis;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d d = state.R_b0_bk[views[k].keyframe] * views[k].direction_b;
    sum += d * d.transpose();
  }
  axis.direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum).eigenvectors().col(2);
  axis.tangent = tangentBasis(axis.direction);
  return axis;
}

}  // namespace slim_init
