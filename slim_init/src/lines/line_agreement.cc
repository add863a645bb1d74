// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "lines/line_agreement.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lines/constants.h"
#include "lines/line_track.h"

namespace slim_init {
namespace {

using namespace lines_constants;  // NOLINT: the constants of this module

// One line against the views [begin, end) of a track.
class Stretch {
 public:
  Stretch(const std::vector<LineView>& views, const WindowState& motion,
          const Eigen::Vector3d& t_b_c)
      : views_(views), motion_(motion), t_b_c_(t_b_c) {}

  bool agrees(int begin, int end, double max_error_rad) const {
    LineParameters line;
    if (!triangulate(&views_[begin], end - begin, motion_, t_b_c_, &line)) return false;
    if (largestError(line, begin, end) <= max_error_rad) return true;
    // The linear line leans on the view in the middle, which may be a short segment; the next ones
    // weigh all views alike.
    for (int step = 0; step < kGaussNewtonSteps; ++step) {
      line = improved(line, begin, end);
      if (largestError(line, begin, end) <= max_error_rad) return true;
    }
    return false;
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

  LineParameters improved(const LineParameters& line, int begin, int end) const {
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    Eigen::Vector4d g = Eigen::Vector4d::Zero();
    for (int a = begin; a < end; ++a) {
      ViewDerivatives<4> view;
      evaluate(views_[a], line, motion_, t_b_c_, 1.0, &view);
      H += view.J_track.transpose() * view.J_track;
      g += view.J_track.transpose() * view.r;
    }
    H.diagonal().array() += kLineDamping * H.diagonal().maxCoeff();
    return line.moved(-H.llt().solve(g));
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
