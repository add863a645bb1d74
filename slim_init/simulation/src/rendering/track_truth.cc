// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/track_truth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace slim_init::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = 3.141592653589793 / 180.0;
// A feature within this distance of a surface's border may belong to that surface [px]: the one
// that explains the whole track best is taken.
constexpr double kBorderPx = 1.5;
constexpr double kKeyframeIntervalS = 0.25;  // [s]
constexpr int kMantle = 6;                   // RayHit::face of a curved surface

// A flat face of a solid.
struct Face {
  int solid = -1;
  int face = -1;
  Vector3d point_w = Vector3d::Zero();
  Vector3d normal_w = Vector3d::UnitZ();
};

bool operator==(const Face& a, const Face& b) { return a.solid == b.solid && a.face == b.face; }

Face faceOf(const RayHit& hit) { return {hit.solid, hit.face, hit.point_w, hit.normal_w}; }

// Where a ray meets the face's plane, in front of the camera.
std::optional<Vector3d> meet(const Face& face, const CameraPose& pose, const Vector3d& bearing_c) {
  const Vector3d d = pose.R_w_c * bearing_c;
  const double along = d.dot(face.normal_w);
  constexpr double kGrazing = 1e-4;
  if (std::abs(along) < kGrazing) return std::nullopt;
  const double distance = (face.point_w - pose.t_w_c).dot(face.normal_w) / along;
  if (!(distance > 1e-3)) return std::nullopt;
  return pose.t_w_c + distance * d;
}

// Two unit vectors perpendicular to a bearing.
std::pair<Vector3d, Vector3d> tangents(const Vector3d& bearing) {
  const Vector3d seed = std::abs(bearing.x()) < 0.7 ? Vector3d::UnitX() : Vector3d::UnitY();
  const Vector3d a = bearing.cross(seed).normalized();
  return {a, bearing.cross(a)};
}

double median(std::vector<double> values) {
  if (values.empty()) return kNotComputed;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// One observation, with the index of its view.
template <typename Observation>
struct Seen {
  int frame = 0;
  const Observation* observation = nullptr;
};

template <typename Observation>
using Track = std::vector<Seen<Observation>>;

template <typename Observation>
using Tracks = std::map<FeatureId, Track<Observation>>;

// The observation of a track in one view; null when it was not seen there.
template <typename Observation>
const Observation* seenAt(const Track<Observation>& track, int frame) {
  const auto it = std::find_if(track.begin(), track.end(),
                               [frame](const auto& seen) { return seen.frame == frame; });
  return it == track.end() ? nullptr : it->observation;
}

// The surface that explains a track best, and the errors of the later observations on it.
template <typename Error>
struct Explanation {
  std::optional<Face> face;
  double median_error = 0.0;
  std::vector<Error> errors;

  void offer(const Face& candidate, double median_of_candidate, std::vector<Error> list) {
    if (face && !(median_of_candidate < median_error)) return;
    face = candidate;
    median_error = median_of_candidate;
    errors = std::move(list);
  }
};

// A 3D line, by two places on it.
struct Line {
  Vector3d start_w, end_w;
};

}  // namespace

// One evaluation over all views.
class TrackTruth::Evaluation {
 public:
  explicit Evaluation(const TrackTruth& truth)
      : scene_(truth.scene_),
        camera_(truth.camera_),
        views_(truth.views_),
        px_(1.0 / truth.camera_.focalPx()) {
    // Keyframes as an initializer takes them: the first image at least an interval after the last.
    keyframe_before_.assign(views_.size(), -1);
    int last = -1;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      constexpr double kSlack = 1e-6;  // [s] stamps are rounded
      if (last >= 0 &&
          views_[i].t - views_[static_cast<std::size_t>(last)].t < kKeyframeIntervalS - kSlack) {
        continue;
      }
      keyframe_before_[i] = last;
      last = static_cast<int>(i);
    }
  }

  TrackQuality run() const {
    TrackQuality quality;
    quality.frames = static_cast<int>(views_.size());
    Tracks<SeenPoint> points;
    Tracks<SeenLine> lines;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      for (const SeenPoint& point : views_[i].points) {
        points[point.seen.id].push_back({static_cast<int>(i), &point});
      }
      for (const SeenLine& line : views_[i].lines) {
        lines[line.seen.id].push_back({static_cast<int>(i), &line});
      }
    }
    for (const auto& [id, track] : points) {
      if (track.size() < 2) continue;
      ++quality.point_tracks;
      measure(track, facesAround(*track.front().observation), &PointError::error_px,
              &quality.point_tracks_without_truth, &quality.points, &quality.keyframe_points);
    }
    for (const auto& [id, track] : lines) {
      if (track.size() < 2) continue;
      ++quality.line_tracks;
      measure(track, facesAlong(*track.front().observation), &LineError::end_px,
              &quality.line_tracks_without_truth, &quality.lines, &quality.keyframe_lines);
    }
    return quality;
  }

 private:
  // The errors of a track on the candidate that explains it best: by the median of `value` over the
  // observations after the first.
  template <typename Observation, typename Error>
  void measure(const Track<Observation>& track, const std::vector<Face>& candidates,
               double Error::*value, int* without_truth, std::vector<Error>* errors,
               std::vector<Error>* keyframe_errors) const {
    const Seen<Observation>& first = track.front();
    Explanation<Error> best;
    for (const Face& face : candidates) {
      const auto place = placeOn(face, *first.observation);
      if (!place) continue;
      std::vector<Error> found;
      std::vector<double> values;
      for (std::size_t k = 1; k < track.size(); ++k) {
        found.push_back(errorOf(*place, face, first.frame, track[k]));
        values.push_back(found.back().*value);
      }
      best.offer(face, median(values), std::move(found));
    }
    if (!best.face) {
      ++*without_truth;
      return;
    }
    errors->insert(errors->end(), best.errors.begin(), best.errors.end());

    // From keyframe to keyframe, starting again from the surface.
    for (std::size_t k = 1; k < track.size(); ++k) {
      const int before = keyframe_before_[static_cast<std::size_t>(track[k].frame)];
      const Observation* from = before < 0 ? nullptr : seenAt(track, before);
      if (from == nullptr) continue;
      const auto place = placeOn(*best.face, *from);
      if (!place) continue;
      keyframe_errors->push_back(errorOf(*place, *best.face, before, track[k]));
    }
  }

  // --- Points ---

  // Surfaces at a point and around it.
  std::vector<Face> facesAround(const SeenPoint& first) const {
    const Vector3d& bearing = first.seen.bearing;
    const CameraPose& from = first.pose;
    const auto [a, b] = tangents(bearing);
    std::vector<Face> faces;
    constexpr int kAround = 8;
    for (int i = 0; i <= kAround; ++i) {
      const double angle = 360.0 / kAround * kDegree * i;
      const double reach = i == kAround ? 0.0 : kBorderPx * px_;
      const Vector3d ray = bearing + reach * std::cos(angle) * a + reach * std::sin(angle) * b;
      const RayHit hit = scene_.castRay(from.t_w_c, from.R_w_c * ray);
      if (!hit.hit()) continue;
      const Face face = faceOf(hit);
      if (std::find(faces.begin(), faces.end(), face) == faces.end()) faces.push_back(face);
    }
    return faces;
  }

  // Where an observation meets a surface; for a curved one the ray itself is cast.
  std::optional<Vector3d> placeOn(const Face& face, const SeenPoint& from) const {
    if (face.face != kMantle) return meet(face, from.pose, from.seen.bearing);
    const RayHit hit = scene_.castRay(from.pose.t_w_c, from.pose.R_w_c * from.seen.bearing);
    if (!hit.hit()) return std::nullopt;
    return hit.point_w;
  }

  PointError errorOf(const Vector3d& place_w, const Face& face, int from,
                     const Seen<SeenPoint>& at) const {
    const PointObservation& seen = at.observation->seen;
    const CameraPose& to = at.observation->pose;
    const Vector3d place_c = to.R_w_c.transpose() * (place_w - to.t_w_c);
    PointError error;
    error.id = seen.id;
    error.frame = at.frame;
    error.age = at.frame - from;
    error.solid = face.solid;
    Vector2d pixel;
    if (camera_.project(place_c, &pixel)) {
      constexpr double kSurface = 0.02;  // [m]; a relief lower than this does not hide a wall
      error.error_px = (pixel - seen.pixel).norm();
      error.occluded = !scene_.visible(to.t_w_c, place_w, kSurface);
    } else {
      error.error_px = place_c.normalized().cross(seen.bearing).norm() / px_;
      error.occluded = true;
    }
    return error;
  }

  // --- Lines ---

  // Surfaces that are seen along a segment, on it or beside it; none where one of them is curved.
  std::vector<Face> facesAlong(const SeenLine& first) const {
    const CameraPose& from = first.start_pose;
    const Vector3d& start = first.seen.start_bearing;
    // As seen at the time of the start.
    const Vector3d end = from.R_w_c.transpose() * (first.end_pose.R_w_c * first.seen.end_bearing);
    const Vector3d normal = start.cross(end).normalized();
    constexpr int kPlaces = 5;
    std::vector<std::pair<Face, int>> counted;  // and the number of places where it is seen
    for (int i = 0; i < kPlaces; ++i) {
      const double s = 0.1 + 0.8 * i / (kPlaces - 1);
      const Vector3d on = ((1.0 - s) * start + s * end).normalized();
      std::vector<Face> here;
      for (const double side : {0.0, -1.0, 1.0}) {
        const RayHit hit =
            scene_.castRay(from.t_w_c, from.R_w_c * (on + side * kBorderPx * px_ * normal));
        if (!hit.hit()) continue;
        if (hit.face == kMantle) return {};
        const Face face = faceOf(hit);
        if (std::find(here.begin(), here.end(), face) == here.end()) here.push_back(face);
      }
      for (const Face& face : here) {
        const auto known = std::find_if(counted.begin(), counted.end(),
                                        [&](const auto& f) { return f.first == face; });
        if (known == counted.end()) {
          counted.emplace_back(face, 1);
        } else {
          ++known->second;
        }
      }
    }
    std::vector<Face> faces;
    for (const auto& [face, places] : counted) {
      // One place may be hidden behind something thin.
      if (places >= kPlaces - 1) faces.push_back(face);
    }
    return faces;
  }

  std::optional<Line> placeOn(const Face& face, const SeenLine& line) const {
    const auto start = meet(face, line.start_pose, line.seen.start_bearing);
    const auto end = meet(face, line.end_pose, line.seen.end_bearing);
    if (!start || !end) return std::nullopt;
    return Line{*start, *end};
  }

  // Unit normal of the plane through the camera and a line.
  static Vector3d normalFrom(const CameraPose& pose, const Line& line) {
    const Vector3d start = pose.R_w_c.transpose() * (line.start_w - pose.t_w_c);
    const Vector3d end = pose.R_w_c.transpose() * (line.end_w - pose.t_w_c);
    return start.cross(end).normalized();
  }

  LineError errorOf(const Line& line, const Face& face, int from, const Seen<SeenLine>& at) const {
    const Vector3d& start = at.observation->seen.start_bearing;
    const Vector3d& end = at.observation->seen.end_bearing;
    // Sines of the ends' distances from the line, each at its own time. With s and e the ends, n
    // the normal and m = (s + e) / |s + e| the middle, m . n is the middle's distance, and the
    // segment's direction (e - s) / |e - s| is inclined to the line by (e - s) . n / |e - s| over
    // the length of n across m.
    const double off_start = start.dot(normalFrom(at.observation->start_pose, line));
    const double off_end = end.dot(normalFrom(at.observation->end_pose, line));
    const double off_middle = (off_start + off_end) / (start + end).norm();
    const double inclination =
        (off_end - off_start) /
        ((end - start).norm() * std::sqrt(std::max(1e-12, 1.0 - off_middle * off_middle)));
    LineError error;
    error.id = at.observation->seen.id;
    error.frame = at.frame;
    error.age = at.frame - from;
    error.solid = face.solid;
    error.offset_px = std::abs(std::asin(std::clamp(off_middle, -1.0, 1.0))) / px_;
    error.end_px = std::max(std::abs(off_start), std::abs(off_end)) / px_;
    error.angle_deg = std::asin(std::min(1.0, std::abs(inclination))) / kDegree;
    return error;
  }

  const Scene& scene_;
  const feature_tracker_lines::Camera& camera_;
  const std::vector<View>& views_;
  double px_;                         // [rad] of one pixel at the axis
  std::vector<int> keyframe_before_;  // of a view that is a keyframe; otherwise -1
};

void TrackTruth::addFrame(const FrameObservation& frame, const PoseAtRow& pose_at) {
  View view;
  view.t = frame.t;
  for (const PointObservation& point : frame.points) {
    view.points.push_back({point, pose_at(point.row)});
  }
  for (const LineObservation& line : frame.lines) {
    view.lines.push_back({line, pose_at(line.start_row), pose_at(line.end_row)});
  }
  views_.push_back(std::move(view));
}

TrackQuality TrackTruth::evaluate() const { return Evaluation(*this).run(); }

}  // namespace slim_init::simulation
