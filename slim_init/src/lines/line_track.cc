// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "lines/line_track.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "data/clean_frame.h"
#include "geometry/so3.h"

namespace slim_init {

LineParameters LineParameters::moved(const Eigen::Vector4d& step) const {
  LineParameters out = *this;
  out.frame = expSO3(step.head<3>()) * frame;
  out.inverse_distance += step[3];
  return out;
}

void evaluate(const LineView& view, const LineParameters& line, const WindowState& state,
              const CameraPlace& camera, double sqrt_information, ViewDerivatives<4>* out) {
  const Eigen::Matrix3d& R = state.R_b0_bk[view.keyframe];
  const double rho = line.inverse_distance;
  const Eigen::Vector3d D = line.frame.col(1);
  const Eigen::Vector3d w = line.frame.col(2);
  const Eigen::Vector3d from_camera =
      line.origin - (cameraCentre(state, view.keyframe, camera.t_b_c) + camera.moved);
  const Eigen::Vector3d n = w + rho * from_camera.cross(D);
  const double inverse_norm = 1.0 / n.norm();
  const Eigen::Vector3d n_b = R.transpose() * n;
  const Eigen::Vector3d unit = n_b * inverse_norm;
  const Eigen::Vector3d D_b = R.transpose() * D;

  const Eigen::Matrix3d dn_dtheta = skew(n_b) - rho * skew(D_b) * skew(camera.t_b_c);
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

bool triangulate(const LineView* views, int count, const WindowState& state,
                 const Eigen::Vector3d& t_b_c, LineParameters* line) {
  const LineView& middle = views[count / 2];
  line->origin = cameraCentre(state, middle.keyframe, t_b_c);
  const Eigen::Matrix3d& R_middle = state.R_b0_bk[middle.keyframe];
  const Eigen::Vector3d across = middle.start_b.cross(middle.end_b);
  if (!(across.squaredNorm() > kMinLineAngle * kMinLineAngle)) return false;  // or not a number
  const Eigen::Vector3d w = (R_middle * across).normalized();
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
      a > 0.0 ? std::clamp(b / a, -kMaxStartInverseDistance, kMaxStartInverseDistance) : 0.0;
  return true;
}

namespace {

// One line against the views [begin, end) of a track.
class Stretch {
 public:
  Stretch(const std::vector<LineView>& views, const WindowState& motion,
          const Eigen::Vector3d& t_b_c)
      : views_(views), motion_(motion), t_b_c_(t_b_c) {}

  bool agrees(int begin, int end, double max_error_rad) const {
    LineParameters line;
    return triangulate(&views_[begin], end - begin, motion_, t_b_c_, &line) &&
           largestError(line, begin, end) <= max_error_rad;
  }

 private:
  // Largest |sine| of an end point to the line's plane; NaN counts as infinite.
  double largestError(const LineParameters& line, int begin, int end) const {
    const Eigen::Vector3d D = line.frame.col(1), w = line.frame.col(2);
    double largest = 0.0;
    for (int a = begin; a < end; ++a) {
      const Eigen::Matrix3d& R = motion_.R_b0_bk[views_[a].keyframe];
      const Eigen::Vector3d centre = motion_.p_b0.col(views_[a].keyframe) + R * t_b_c_;
      const Eigen::Vector3d n =
          R.transpose() *
          (w + line.inverse_distance * (line.origin - centre).cross(D)).normalized();
      const double error =
          std::max(std::abs(n.dot(views_[a].start_b)), std::abs(n.dot(views_[a].end_b)));
      if (!(error <= largest)) largest = std::isfinite(error) ? error : HUGE_VAL;
    }
    return largest;
  }

  const std::vector<LineView>& views_;
  const WindowState& motion_;
  const Eigen::Vector3d& t_b_c_;
};

struct Range {
  int begin = 0, end = 0;
  int size() const { return end - begin; }
};

// The longest agreeing stretch within `range`, the first of equals. A stretch that does not agree
// has none that contains it, so both ends only ever move forward.
Range longest(const Stretch& stretch, const Range& range, double max_error_rad) {
  if (stretch.agrees(range.begin, range.end, max_error_rad)) return range;
  Range best;
  int begin = range.begin;
  for (int end = range.begin + 2; end <= range.end; ++end) {
    while (end - begin > 2 && !stretch.agrees(begin, end, max_error_rad)) ++begin;
    if (end - begin > best.size()) best = {begin, end};
  }
  return best;
}

}  // namespace

std::vector<Track> agreeingLineTracks(const InitWindow& window, const WindowState& motion,
                                      double max_error_rad, int min_views) {
  std::vector<Track> out;
  const Eigen::Matrix3d& R_b_c = window.calibration().R_b_c;
  std::vector<LineView> views;
  std::vector<Range> open;
  for (const Track& track : window.lineTracks()) {
    if (track.size() < min_views) continue;
    views.clear();
    for (int s = track.begin; s < track.end; ++s) {
      const WindowLine& line = window.lineObservations()[s];
      views.push_back({line.keyframe, R_b_c * line.start_bearing, R_b_c * line.end_bearing});
    }
    const Stretch stretch(views, motion, window.calibration().t_b_c);
    open.assign(1, {0, track.size()});
    while (!open.empty()) {
      const Range range = open.back();
      open.pop_back();
      if (range.size() < min_views) continue;
      const Range found = longest(stretch, range, max_error_rad);
      if (found.size() < min_views) continue;
      out.push_back({track.id, track.begin + found.begin, track.begin + found.end});
      open.push_back({found.end, range.end});
      open.push_back({range.begin, found.begin});
    }
  }
  return out;
}

}  // namespace slim_init
