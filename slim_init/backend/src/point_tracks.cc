// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "point_tracks.h"

#include <algorithm>
#include <cmath>

#include "geometry/so3.h"
#include "reprojection_cost.h"

namespace slim_init::backend {
namespace {

// Nearer than this no camera is in focus [1/m].
constexpr double kMaxInverseDistance = 10.0;
// A point at infinity comes out this far behind the camera by noise alone [1/m].
constexpr double kBehind = -0.02;
// Summed squared sine of the parallax per squared metre below which the default depth is taken.
constexpr double kMinInformation = 1e-6;

const PointView* findView(const PointTrack& track, FrameId frame) {
  for (const PointView& view : track.views) {
    if (view.frame == frame) return &view;
  }
  return nullptr;
}

// Least squares over u_j x (a_j + lambda b_j) = 0, which is linear in the inverse distance.
double solveInverseDistance(const PointTrack& track, const Frames& frames,
                            const Calibration& calibration, double default_depth_m) {
  const Frame& host = *findFrame(frames, track.views.front().frame);
  double information = 0.0, gradient = 0.0;
  for (std::size_t k = 1; k < track.views.size(); ++k) {
    const Frame& frame = *findFrame(frames, track.views[k].frame);
    const auto at = [&](double lambda) {
      return transferPoint(host.rotation(), host.position(), frame.rotation(), frame.position(),
                           calibration, track.views.front().bearing, lambda)
          .q;
    };
    const Eigen::Vector3d a = at(0.0);
    const Eigen::Vector3d b = at(1.0) - a;
    const Eigen::Vector3d ua = track.views[k].bearing.cross(a);
    const Eigen::Vector3d ub = track.views[k].bearing.cross(b);
    information += ub.squaredNorm();
    gradient += ub.dot(ua);
  }
  if (information < kMinInformation) return 1.0 / default_depth_m;
  const double lambda = -gradient / information;
  return std::clamp(lambda, 1e-3, kMaxInverseDistance);
}

}  // namespace

int PointTracks::addFrame(FrameId frame, FrameId previous,
                          const std::vector<PointObservation>& points) {
  int tracked = 0;
  for (const PointObservation& point : points) {
    const double norm = point.bearing.norm();
    if (!point.bearing.allFinite() || !(norm > 0.0)) continue;
    PointTrack& track = tracks_[point.id];
    if (!track.views.empty()) {
      if (track.views.back().frame == frame) continue;  // second use of an id
      if (track.views.back().frame == previous) ++tracked;
    }
    track.views.push_back({frame, point.bearing / norm});
  }
  return tracked;
}

void PointTracks::triangulate(const Frames& frames, const Calibration& calibration,
                              double default_depth_m) {
  for (auto& [id, track] : tracks_) {
    if (track.estimated || track.views.size() < 2) continue;
    track.inverse_distance = solveInverseDistance(track, frames, calibration, default_depth_m);
    track.estimated = true;
  }
}

void PointTracks::forgetDistances() {
  for (auto& [id, track] : tracks_) track.estimated = false;
}

void PointTracks::removeBehind() {
  for (auto it = tracks_.begin(); it != tracks_.end();) {
    const bool behind = it->second.estimated && !(it->second.inverse_distance > kBehind);
    it = behind ? tracks_.erase(it) : std::next(it);
  }
}

void PointTracks::removeViews(int count, const Frames& frames, const Calibration& calibration,
                              PointTrack* track) {
  const PointView host = track->views.front();
  track->views.erase(track->views.begin(), track->views.begin() + count);
  if (track->views.empty() || !track->estimated) return;
  const Frame& old_frame = *findFrame(frames, host.frame);
  const Frame& new_frame = *findFrame(frames, track->views.front().frame);
  // q is lambda times the point seen from the new host, whose distance is |q| / lambda.
  const Eigen::Vector3d q =
      transferPoint(old_frame.rotation(), old_frame.position(), new_frame.rotation(),
                    new_frame.position(), calibration, host.bearing, track->inverse_distance)
          .q;
  const double norm = q.norm();
  track->estimated = norm > 1e-9 && q.dot(track->views.front().bearing) > 0.0;
  if (track->estimated) track->inverse_distance /= norm;
}

void PointTracks::removeFrame(FrameId frame, const Frames& frames, const Calibration& calibration) {
  for (auto it = tracks_.begin(); it != tracks_.end();) {
    PointTrack& track = it->second;
    if (track.views.front().frame == frame) {
      removeViews(1, frames, calibration, &track);
    } else {
      track.views.erase(std::remove_if(track.views.begin(), track.views.end(),
                                       [&](const PointView& v) { return v.frame == frame; }),
                        track.views.end());
    }
    it = track.views.empty() ? tracks_.erase(it) : std::next(it);
  }
}

PointTracks::Parallax PointTracks::parallax(const Frame& i, const Frame& j,
                                            const Calibration& calibration) const {
  const Eigen::Matrix3d R_c_b = calibration.R_b_c.transpose();
  const Eigen::Matrix3d R_ci_cj =
      R_c_b * i.rotation().transpose() * j.rotation() * calibration.R_b_c;
  Parallax result;
  for (const auto& [id, track] : tracks_) {
    const PointView* in_i = findView(track, i.id);
    const PointView* in_j = findView(track, j.id);
    if (in_i == nullptr || in_j == nullptr) continue;
    const Eigen::Vector3d turned = R_ci_cj * in_j->bearing;
    result.mean += std::atan2(in_i->bearing.cross(turned).norm(), in_i->bearing.dot(turned));
    ++result.tracks;
  }
  if (result.tracks > 0) result.mean /= result.tracks;
  return result;
}

}  // namespace slim_init::backend
