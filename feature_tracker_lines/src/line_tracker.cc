// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "line_tracker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/video/tracking.hpp>

namespace slim_init::feature_tracker_lines {
namespace {

constexpr double kRadPerDeg = 0.017453292519943295;

// KLT of points on lines: a smaller window than for corners, since the edge itself is what counts,
// and few iterations, since along the edge there is nothing to converge to.
constexpr int kWindowPx = 13;
// A line with a history is predicted to a pixel or two; a new one may be off by more.
constexpr int kLevelsKnown = 0, kLevelsNew = 1;
const cv::TermCriteria kFlowEnd(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 8, 0.02);
// On an edge the smaller eigenvalue says nothing.
constexpr double kLeastEigenvalue = 1e-7;
constexpr double kMaxCorrectionPx = 8.0;  // across, from the prediction
constexpr double kSampleScalePx = 0.7;    // Cauchy scale of the moved samples about their line
constexpr double kLeastMoved = 0.6;       // share of samples that KLT has to find

// The detector works on level 1 of the pyramid: a quarter of the time, and the refit on the full
// image gives the precision.
constexpr int kDetectionLevel = 1;
constexpr int kDetectionScale = 1 << kDetectionLevel;

constexpr double kSearchNewPx = 3.0;  // the detection is good to a pixel of level 1
constexpr double kSearchTrackedPx = 2.0;
constexpr double kLeastSupport = 0.6;
constexpr double kMaxJumpPx = 1.5;  // refit from prediction; beyond is the neighbouring edge
// A tracked line may get this much shorter than a new one before it is let go.
constexpr double kShortening = 0.7;
// Two lines this close and overlapping are one.
constexpr double kSameDistancePx = 1.0, kSameOverlap = 0.5, kNewDistancePx = 3.0;
constexpr double kContrastNoises = 5.0;
// Lines seen so often count twice their length when places are short.
constexpr int kEstablishedAge = 20;

struct Overlap {
  double share = 0.0;        // of the shorter one
  double distance_px = 0.0;  // mean over its ends, across
  double largest_px = 0.0;
  double angle = 0.0;  // [rad], of no sense
};

// The segment from `start` to `end` in the frame of a line. The share is zero where they do not
// overlap, or face away from each other.
Overlap overlapOf(const ArcFrame& line, const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                  double focal_px) {
  Overlap result;
  if (!(start.dot(line.u) > 0.1 && end.dot(line.u) > 0.1)) return result;
  const double x0 = line.alongOf(start), x1 = line.alongOf(end);
  if (!(x1 > x0)) return result;
  const double low = std::max(x0, line.x_start), high = std::min(x1, line.x_end);
  if (!(high > low)) return result;
  const double y0 = line.acrossOf(start), y1 = line.acrossOf(end);
  const double slope = (y1 - y0) / (x1 - x0);
  const double y_low = (y0 + slope * (low - x0)) * focal_px;
  const double y_high = (y0 + slope * (high - x0)) * focal_px;
  result.share = (high - low) / std::min(x1 - x0, line.x_end - line.x_start);
  result.distance_px = 0.5 * (std::abs(y_low) + std::abs(y_high));
  result.largest_px = std::max(std::abs(y_low), std::abs(y_high));
  result.angle = std::atan(std::abs(slope));
  return result;
}

// Whether both ends lie on one side of the plane and farther than `distance_px` from it: then so
// does all between them. Exact, and far cheaper than overlapOf().
bool liesAside(const Eigen::Vector3d& normal, const Eigen::Vector3d& start,
               const Eigen::Vector3d& end, double focal_px, double distance_px) {
  const double a = normal.dot(start), b = normal.dot(end);
  return a * b > 0.0 && std::min(std::abs(a), std::abs(b)) * focal_px > distance_px;
}

double rankOf(const LineTrack& track) {
  return track.edge.length_px *
         (1.0 + std::min(track.age - 1, kEstablishedAge) / static_cast<double>(kEstablishedAge));
}

double confidenceOf(const Edge& edge, double noise) {
  return edge.support * edge.contrast / (edge.contrast + kContrastNoises * noise);
}

}  // namespace

// A detection, brighter on the side of start x end.
struct LineTracker::Segment {
  Eigen::Vector3d start, end;
  double length_px = 0.0;
  bool taken = false;
};

// Where a tracked line is expected.
struct LineTracker::Prediction {
  bool ok = false;
  Eigen::Vector3d start, end;
};

LineTracker::LineTracker(const CameraParameters& camera, const FrontEndOptions& options)
    : camera_(camera),
      options_(options),
      focal_px_(camera_.focalPx()),
      detector_(makeLineDetector(options.lines.min_length_px / kDetectionScale)) {}

void LineTracker::reset() {
  tracks_.clear();
  detected_.clear();
}

std::vector<LineTracker::Segment> LineTracker::detect(const ImagePyramid& now) {
  const int level = std::min(kDetectionLevel, now.max_level);
  const int scale = 1 << level;
  // A copy: the level lies in a larger, padded image, and the detector takes rows as contiguous.
  now.level(level).copyTo(half_);
  std::vector<cv::Vec4f> found;
  detector_->detect(half_, &found);
  detected_.clear();

  std::vector<Segment> segments;
  for (const cv::Vec4f& s : found) {
    cv::Point2f a(s[0], s[1]), b(s[2], s[3]);
    const cv::Point2f along = b - a;
    const auto length = static_cast<float>(cv::norm(along));
    if (!(length * static_cast<float>(scale) >= options_.lines.min_length_px)) continue;
    detected_.push_back(s * static_cast<float>(scale));
    // The brighter side, from a few places along it.
    const cv::Point2f across(-along.y / length, along.x / length);
    int difference = 0;
    constexpr int kPlaces = 7;
    for (int i = 1; i <= kPlaces; ++i) {
      const cv::Point2f p = a + along * (static_cast<float>(i) / (kPlaces + 1));
      for (const float off : {1.0F, 2.0F}) {
        const cv::Point right(cvRound(p.x + off * across.x), cvRound(p.y + off * across.y));
        const cv::Point left(cvRound(p.x - off * across.x), cvRound(p.y - off * across.y));
        const cv::Rect inside(0, 0, half_.cols, half_.rows);
        if (!inside.contains(right) || !inside.contains(left)) continue;
        difference += half_.at<uchar>(right) - half_.at<uchar>(left);
      }
    }
    if (difference < 0) std::swap(a, b);
    Segment segment;
    segment.start = camera_.bearing(Eigen::Vector2d(a.x, a.y) * scale);
    segment.end = camera_.bearing(Eigen::Vector2d(b.x, b.y) * scale);
    if (!segment.start.allFinite() || !segment.end.allFinite()) continue;
    segment.length_px = length * scale;
    segments.push_back(segment);
  }
  // The longest first; in a given order, so that equal inputs give equal ids.
  std::stable_sort(segments.begin(), segments.end(),
                   [](const Segment& a, const Segment& b) { return a.length_px > b.length_px; });
  return segments;
}

std::vector<LineTracker::Prediction> LineTracker::predict(const ImagePyramid& before,
                                                          const ImagePyramid& now,
                                                          const RotationPrior& prior,
                                                          const PointTracker& points) const {
  const int samples = options_.lines.samples;
  std::vector<Prediction> predictions(tracks_.size());
  std::vector<cv::Point2f> from, start;
  std::vector<std::size_t> owner;
  std::vector<Eigen::Vector2d> across;  // unit, in the image now
  std::vector<ArcFrame> arcs;
  const Eigen::Matrix3d& R = prior.R_now_before;
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    const LineTrack& track = tracks_[k];
    const ArcFrame here(track.edge.start, track.edge.end);
    // The plane turns with the camera and, by its motion of before, with the translation.
    const Eigen::Vector3d normal = (R * (track.edge.normal() + track.normal_drift)).normalized();
    const auto onto = [&normal, &R](const Eigen::Vector3d& f) {
      const Eigen::Vector3d g = R * f;
      return Eigen::Vector3d((g - normal * normal.dot(g)).normalized());
    };
    arcs.emplace_back(onto(track.edge.start), onto(track.edge.end));
    const ArcFrame& there = arcs.back();
    for (int i = 0; i < samples; ++i) {
      const double share = (i + 0.5) / samples;
      const double x = here.x_start + share * (here.x_end - here.x_start);
      Eigen::Vector2d source, middle, beside;
      const Eigen::Vector3d expected = onto(here.direction(x, 0.0));
      if (!camera_.project(here.direction(x, 0.0), &source) ||
          !camera_.project(expected, &middle) ||
          !camera_.project(expected + 1e-4 * there.n, &beside)) {
        continue;
      }
      Eigen::Vector2d side = (beside - middle).normalized();
      if (track.age < 2) {
        const cv::Point2f flow = points.residualFlowNear(
            cv::Point2f(static_cast<float>(middle.x()), static_cast<float>(middle.y())));
        middle += side * side.dot(Eigen::Vector2d(flow.x, flow.y));
      }
      from.emplace_back(static_cast<float>(source.x()), static_cast<float>(source.y()));
      start.emplace_back(static_cast<float>(middle.x()), static_cast<float>(middle.y()));
      owner.push_back(k);
      across.push_back(side);
    }
  }
  if (from.empty()) return predictions;

  std::vector<cv::Point2f> to = start;
  std::vector<uchar> ok(start.size(), 0);
  for (const bool known : {true, false}) {
    std::vector<std::size_t> chosen;
    std::vector<cv::Point2f> sources, ends;
    for (std::size_t i = 0; i < owner.size(); ++i) {
      if ((tracks_[owner[i]].age >= 2) != known) continue;
      chosen.push_back(i);
      sources.push_back(from[i]);
      ends.push_back(start[i]);
    }
    if (chosen.empty()) continue;
    std::vector<uchar> found;
    std::vector<float> unused;
    cv::calcOpticalFlowPyrLK(
        before.pyramid, now.pyramid, sources, ends, found, unused, cv::Size(kWindowPx, kWindowPx),
        std::min({known ? kLevelsKnown : kLevelsNew, before.max_level, now.max_level}), kFlowEnd,
        cv::OPTFLOW_USE_INITIAL_FLOW, kLeastEigenvalue);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      to[chosen[i]] = ends[i];
      ok[chosen[i]] = found[i];
    }
  }

  std::size_t j = 0;
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    Eigen::ArrayXd x(samples), y(samples);
    int count = 0, asked = 0;
    for (; j < owner.size() && owner[j] == k; ++j, ++asked) {
      if (ok[j] == 0) continue;
      // Along the edge KLT slides as it likes; across it is right.
      const Eigen::Vector2d p(start[j].x, start[j].y);
      const double moved = across[j].dot(Eigen::Vector2d(to[j].x, to[j].y) - p);
      if (!(std::abs(moved) <= kMaxCorrectionPx)) continue;
      const Eigen::Vector3d f = camera_.bearing(p + moved * across[j]);
      if (!f.allFinite() || !(f.dot(arcs[k].u) > 0.1)) continue;
      x[count] = arcs[k].alongOf(f);
      y[count] = arcs[k].acrossOf(f);
      ++count;
    }
    if (count < 3 || count < kLeastMoved * samples) continue;
    const StraightFit fit = fitStraight(x.head(count), y.head(count), kSampleScalePx / focal_px_);
    if (!fit.ok) continue;
    const ArcFrame& arc = arcs[k];
    predictions[k].ok = true;
    predictions[k].start = arc.direction(arc.x_start, fit.offset + fit.slope * arc.x_start);
    predictions[k].end = arc.direction(arc.x_end, fit.offset + fit.slope * arc.x_end);
  }
  return predictions;
}

bool LineTracker::isSameLine(const Edge& a, const Edge& b, double max_distance_px) const {
  if (liesAside(a.normal(), b.start, b.end, focal_px_, max_distance_px)) return false;
  const Overlap overlap = overlapOf(ArcFrame(a.start, a.end), b.start, b.end, focal_px_);
  return overlap.share >= kSameOverlap && overlap.largest_px <= max_distance_px;
}

void LineTracker::track(const ImagePyramid& before, const ImagePyramid& now,
                        const RotationPrior& prior, const PointTracker& points,
                        FrontEndReport* report) {
  const LineTrackerOptions& o = options_.lines;
  report->lines_before = static_cast<int>(tracks_.size());
  std::vector<Segment> segments = detect(now);
  report->lines_detected = static_cast<int>(segments.size());

  std::vector<Prediction> predictions;
  if (before.empty()) {
    tracks_.clear();
  } else {
    predictions = predict(before, now, prior, points);
  }

  // Each line and each detection with its best partner.
  const std::size_t lines = tracks_.size(), found = segments.size();
  std::vector<int> best_of_line(lines, -1), best_of_segment(found, -1);
  std::vector<double> cost_of_line(lines, 1e9), cost_of_segment(found, 1e9);
  std::vector<Overlap> overlap_of_line(lines);
  for (std::size_t k = 0; k < lines; ++k) {
    if (!predictions[k].ok) continue;
    const ArcFrame arc(predictions[k].start, predictions[k].end);
    for (std::size_t s = 0; s < found; ++s) {
      if (liesAside(arc.n, segments[s].start, segments[s].end, focal_px_, o.max_distance_px)) {
        continue;
      }
      const Overlap overlap = overlapOf(arc, segments[s].start, segments[s].end, focal_px_);
      if (overlap.share < o.min_overlap || overlap.largest_px > o.max_distance_px ||
          overlap.angle > o.max_angle_deg * kRadPerDeg) {
        continue;
      }
      const double cost = overlap.distance_px / o.max_distance_px + (1.0 - overlap.share);
      if (cost < cost_of_line[k]) {
        cost_of_line[k] = cost;
        best_of_line[k] = static_cast<int>(s);
        overlap_of_line[k] = overlap;
      }
      if (cost < cost_of_segment[s]) {
        cost_of_segment[s] = cost;
        best_of_segment[s] = static_cast<int>(k);
      }
    }
  }

  std::vector<LineTrack> kept;
  for (std::size_t k = 0; k < lines; ++k) {
    if (!predictions[k].ok) continue;
    Eigen::Vector3d start = predictions[k].start, end = predictions[k].end;
    const int s = best_of_line[k];
    const bool matched =
        s >= 0 && best_of_segment[static_cast<std::size_t>(s)] == static_cast<int>(k);
    LineTrack track = tracks_[k];
    track.missed = matched ? 0 : track.missed + 1;
    if (track.missed > o.max_missed) continue;
    if (matched) {
      Segment& segment = segments[static_cast<std::size_t>(s)];
      segment.taken = true;
      // As far as either of them reaches; the refit cuts off what is no edge.
      const ArcFrame arc(start, end);
      const double x0 = std::min(arc.x_start, arc.alongOf(segment.start));
      const double x1 = std::max(arc.x_end, arc.alongOf(segment.end));
      start = arc.direction(x0, 0.0);
      end = arc.direction(x1, 0.0);
    }
    if (!fitEdge(now.level(0), camera_, start, end, kSearchTrackedPx, now.noise, kLeastSupport,
                 o.max_refit_rms_px, &track.edge) ||
        track.edge.length_px < kShortening * o.min_length_px) {
      continue;
    }
    const Overlap moved = overlapOf(ArcFrame(predictions[k].start, predictions[k].end),
                                    track.edge.start, track.edge.end, focal_px_);
    if (!(moved.share > 0.0) || moved.largest_px > kMaxJumpPx) continue;
    const double certainty = std::exp(-0.5 * moved.distance_px * moved.distance_px);
    track.match_quality = certainty * (matched ? 0.5 + 0.5 * std::min(1.0, overlap_of_line[k].share)
                                               : std::pow(0.5, track.missed));
    track.confidence = confidenceOf(track.edge, now.noise);
    track.normal_drift = track.edge.normal() - prior.R_now_before * tracks_[k].edge.normal();
    ++track.age;
    kept.push_back(track);
  }

  // Two tracks that ended on one edge: the longer known one has it.
  std::stable_sort(kept.begin(), kept.end(),
                   [](const LineTrack& a, const LineTrack& b) { return rankOf(a) > rankOf(b); });
  tracks_.clear();
  const auto isTaken = [this](const Edge& edge, double distance_px) {
    return std::any_of(tracks_.begin(), tracks_.end(), [&](const LineTrack& other) {
      return isSameLine(other.edge, edge, distance_px);
    });
  };
  for (const LineTrack& track : kept) {
    if (isTaken(track.edge, kSameDistancePx)) continue;
    tracks_.push_back(track);
    ++(track.missed == 0 ? report->lines_matched : report->lines_carried);
  }

  // New ones, longest first, while there is room.
  for (const Segment& segment : segments) {
    if (static_cast<int>(tracks_.size()) >= o.max_lines) break;
    if (segment.taken) continue;
    LineTrack track;
    if (!fitEdge(now.level(0), camera_, segment.start, segment.end, kSearchNewPx, now.noise,
                 kLeastSupport, o.max_refit_rms_px, &track.edge) ||
        track.edge.length_px < o.min_length_px || isTaken(track.edge, kNewDistancePx)) {
      continue;
    }
    track.confidence = confidenceOf(track.edge, now.noise);
    track.id = next_id_++;
    tracks_.push_back(track);
    ++report->lines_new;
  }
}

}  // namespace slim_init::feature_tracker_lines
