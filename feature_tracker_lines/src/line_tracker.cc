// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "line_tracker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/video/tracking.hpp>
#include <utility>

namespace slim_init::feature_tracker_lines {
namespace {

// Points per line that KLT predicts the line with; so many it has to find: two always lie on a
// line.
constexpr int kSamples = 5, kLeastMoved = 3;
// Few iterations, since along the edge there is nothing to converge to.
const cv::TermCriteria kFlowEnd(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 5, 0.02);
// From its second image on the motion of a line is known. Its prediction is then good to a pixel or
// two, and one pyramid level is enough; a new line may be off by more.
constexpr int kAgeOfKnownMotion = 2;
constexpr int kLevelsKnown = 0, kLevelsNew = 1;
// On an edge the smaller eigenvalue says nothing, so that OpenCV's bound on it has to be low.
constexpr double kLeastEigenvalue = 1e-7;
constexpr double kMaxCorrectionPx = 8.0;  // across, from the prediction; more is another edge
constexpr double kSampleScalePx = 0.7;    // Cauchy scale of the moved samples about their line
constexpr double kDerivativeStep = 1e-4;  // [rad], of the numerical direction across a line
// Directions are used up to 84 degrees from the middle of a line: beyond, ArcFrame's coordinates
// grow without bound.
constexpr double kLeastForward = 0.1;

// The detector works on level 1 of the pyramid: a quarter of the time, and the refit on the full
// image gives the precision.
constexpr int kDetectionLevel = 1;
constexpr int kDetectionScale = 1 << kDetectionLevel;
// Search of the refit to either side [px]: a detection is good to a pixel of level 1, a tracked
// line is better.
constexpr double kSearchNewPx = 3.0;
constexpr double kSearchTrackedPx = 2.0;
constexpr double kLeastSupport = 0.6;   // share of the edge samples that the refit has to use
constexpr double kMaxRefitRmsPx = 0.5;  // of the edge samples about the fitted line
constexpr double kMaxJumpPx = 1.5;      // refit to prediction; beyond is the neighbouring edge
// A detection is that of a predicted line up to this distance across and this angle, with an
// overlap of this share of the shorter one.
constexpr double kMaxDistancePx = 2.0, kMaxAngle = 3.0 * 0.017453292519943295;  // [rad]
constexpr double kMinOverlap = 0.4;
// Images without a detection over which a line is tracked by its edge.
constexpr int kMaxMissed = 3;
// A tracked line may get this much shorter than a new one before it is dropped.
constexpr double kShortening = 0.7;
// Two tracks this close and overlapping are one line; a new line keeps a larger distance.
constexpr double kSameDistancePx = 1.0, kNewDistancePx = 3.0;
constexpr double kSameOverlap = 0.5;  // share of the shorter one
// Contrast at which detection confidence is a half, in standard deviations of the image noise.
constexpr double kContrastNoises = 5.0;
// Match quality: standard deviation of the distance to the prediction [px], the share that a match
// without overlap keeps, and the factor for each image without a detection.
constexpr double kMatchSigmaPx = 1.0, kQualityOfMatch = 0.5, kQualityOfMiss = 0.5;
// Lines of this age count double their length when there are more than fit.
constexpr int kEstablishedAge = 20;

// How two segments lie to each other, where they overlap.
struct Overlap {
  double share = 0.0;        // of the shorter one
  double distance_px = 0.0;  // across, mean over the ends of the overlap
  double largest_px = 0.0;   // across, at the farther end
  double angle = 0.0;        // [rad], unsigned
};

// The segment from `start` to `end` in the frame of a line. The share is zero where they do not
// overlap or point in opposite directions.
Overlap overlapOf(const ArcFrame& line, const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                  double focal_px) {
  Overlap result;
  if (!(start.dot(line.u) > kLeastForward && end.dot(line.u) > kLeastForward)) return result;
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
// does everything between them. Exact, and far cheaper than overlapOf().
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

bool hasKnownMotion(const LineTrack& track) { return track.age >= kAgeOfKnownMotion; }

// Unit direction of `f` after the rotation R, moved onto the plane with the unit normal `normal`.
Eigen::Vector3d turnedOnto(const Eigen::Vector3d& normal, const Eigen::Matrix3d& R,
                           const Eigen::Vector3d& f) {
  const Eigen::Vector3d g = R * f;
  return (g - normal * normal.dot(g)).normalized();
}

}  // namespace

// Where a tracked line is expected.
struct LineTracker::Prediction {
  bool ok = false;
  Eigen::Vector3d start, end;
};

// Places along all tracked lines that KLT follows; the places of one line are consecutive.
struct LineTracker::Samples {
  std::vector<ArcFrame> arcs;           // of each line, as predicted
  std::vector<std::size_t> owner;       // of each place: its line
  std::vector<cv::Point2f> before;      // in the previous image [px]
  std::vector<cv::Point2f> expected;    // in the image now [px]
  std::vector<Eigen::Vector2d> across;  // unit, across the line in the image now
  std::vector<cv::Point2f> now;         // found by KLT [px]
  std::vector<uchar> ok;                // 1: found
};

// The detection of a tracked line; `segment` is -1 where there is none.
struct LineTracker::Match {
  int segment = -1;
  Overlap overlap;
};

LineTracker::LineTracker(const CameraParameters& camera, const FrontEndOptions& options)
    : camera_(camera),
      lens_before_(camera_),
      lens_(camera_),
      options_(options),
      focal_px_(camera_.focalPx()),
      detector_(options.lines.min_length_px / kDetectionScale) {}

void LineTracker::reset() {
  tracks_.clear();
  detected_.clear();
}

std::vector<LineSegment> LineTracker::detect(const ImagePyramid& now, const RotationPrior& prior) {
  lens_before_ = lens_;
  lens_ = RowCamera(camera_, prior.rows_now);
  const int level = std::min(kDetectionLevel, now.max_level);
  const int scale = 1 << level;
  std::vector<cv::Vec4f> found;
  detector_.detect(now.derivative(level), now.noise, &found);
  detected_.clear();

  std::vector<LineSegment> segments;
  for (const cv::Vec4f& s : found) {
    const cv::Vec4f whole = s * static_cast<float>(scale);
    const cv::Point2f a(whole[0], whole[1]), b(whole[2], whole[3]);
    LineSegment segment;
    segment.length_px = static_cast<float>(cv::norm(b - a));
    if (!(segment.length_px >= options_.lines.min_length_px)) continue;
    if (isMasked(options_.mask, a) || isMasked(options_.mask, b)) continue;
    detected_.push_back(whole);
    segment.start = lens_.bearing(toEigen(a));
    segment.end = lens_.bearing(toEigen(b));
    if (!segment.start.allFinite() || !segment.end.allFinite()) continue;
    segments.push_back(segment);
  }
  // The longest first. Stable, so that equal inputs give equal ids.
  std::stable_sort(
      segments.begin(), segments.end(),
      [](const LineSegment& a, const LineSegment& b) { return a.length_px > b.length_px; });
  return segments;
}

// Places along the tracked lines, and where they are expected after the rotation.
LineTracker::Samples LineTracker::sampleTracks(const RotationPrior& prior,
                                               const PointMotion& points) const {
  const Eigen::Matrix3d& R = prior.R_now_before;
  Samples samples;
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    const LineTrack& track = tracks_[k];
    const ArcFrame here(track.edge.start, track.edge.end);
    // The plane turns with the camera and, as in the previous step, with the translation.
    const bool known = points.steady && hasKnownMotion(track);
    Eigen::Vector3d normal = track.edge.normal();
    if (known) normal += prior.dt_ratio * track.normal_drift;
    normal = (R * normal).normalized();
    samples.arcs.emplace_back(turnedOnto(normal, R, track.edge.start),
                              turnedOnto(normal, R, track.edge.end));
    const ArcFrame& there = samples.arcs.back();
    for (int i = 0; i < kSamples; ++i) {
      const double share = (i + 0.5) / kSamples;
      const double x = here.x_start + share * (here.x_end - here.x_start);
      Eigen::Vector2d before, middle, beside;
      const Eigen::Vector3d expected = turnedOnto(normal, R, here.direction(x, 0.0));
      if (!lens_before_.project(here.direction(x, 0.0), &before) ||
          !lens_.project(expected, &middle) ||
          !lens_.project(expected + kDerivativeStep * there.n, &beside)) {
        continue;
      }
      const Eigen::Vector2d across = (beside - middle).normalized();
      if (!known) {
        middle += across * across.dot(toEigen(points.flowNear(toPoint(middle))));
      }
      samples.owner.push_back(k);
      samples.before.push_back(toPoint(before));
      samples.expected.push_back(toPoint(middle));
      samples.across.push_back(across);
    }
  }
  samples.now = samples.expected;
  samples.ok.assign(samples.expected.size(), 0);
  return samples;
}

// KLT of the places `chosen` over `levels` pyramid levels above the image.
void LineTracker::followSamples(const ImagePyramid& before, const ImagePyramid& now,
                                const std::vector<std::size_t>& chosen, int levels,
                                Samples* samples) const {
  if (chosen.empty()) return;
  std::vector<cv::Point2f> sources, ends;
  for (const std::size_t i : chosen) {
    sources.push_back(samples->before[i]);
    ends.push_back(samples->expected[i]);
  }
  std::vector<uchar> found;
  std::vector<float> unused;
  cv::calcOpticalFlowPyrLK(before.pyramid, now.pyramid, sources, ends, found, unused,
                           cv::Size(kWindowPx, kWindowPx),
                           std::min({levels, before.max_level, now.max_level}), kFlowEnd,
                           cv::OPTFLOW_USE_INITIAL_FLOW, kLeastEigenvalue);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    samples->now[chosen[i]] = ends[i];
    samples->ok[chosen[i]] = found[i];
  }
}

// A straight line through the places of line `k`, which are [first, last) of `samples`.
LineTracker::Prediction LineTracker::fitSamples(const Samples& samples, std::size_t k,
                                                std::size_t first, std::size_t last) const {
  Prediction prediction;
  const ArcFrame& arc = samples.arcs[k];
  Eigen::ArrayXd x(kSamples), y(kSamples);
  int count = 0;
  for (std::size_t j = first; j < last; ++j) {
    if (samples.ok[j] == 0) continue;
    // Along the edge the result of KLT is arbitrary; across it, it is right.
    const Eigen::Vector2d& across = samples.across[j];
    const Eigen::Vector2d expected = toEigen(samples.expected[j]);
    const double moved = across.dot(toEigen(samples.now[j]) - expected);
    if (!(std::abs(moved) <= kMaxCorrectionPx)) continue;
    const Eigen::Vector3d f = lens_.bearing(expected + moved * across);
    if (!f.allFinite() || !(f.dot(arc.u) > kLeastForward)) continue;
    x[count] = arc.alongOf(f);
    y[count] = arc.acrossOf(f);
    ++count;
  }
  if (count < kLeastMoved) return prediction;
  const StraightFit fit = fitStraight(x.head(count), y.head(count), kSampleScalePx / focal_px_);
  if (!fit.ok) return prediction;
  prediction.ok = true;
  prediction.start = arc.direction(arc.x_start, fit.offset + fit.slope * arc.x_start);
  prediction.end = arc.direction(arc.x_end, fit.offset + fit.slope * arc.x_end);
  return prediction;
}

std::vector<LineTracker::Prediction> LineTracker::predict(const ImagePyramid& before,
                                                          const ImagePyramid& now,
                                                          const RotationPrior& prior,
                                                          const PointMotion& points) const {
  // Where the points were not where they had been predicted, the rotation is wrong or the camera
  // jerks: then they tell more than a line's own motion.
  const bool steady = points.steady;
  Samples samples = sampleTracks(prior, points);
  std::vector<std::size_t> of_known, of_new;
  for (std::size_t i = 0; i < samples.owner.size(); ++i) {
    (steady && hasKnownMotion(tracks_[samples.owner[i]]) ? of_known : of_new).push_back(i);
  }
  followSamples(before, now, of_known, kLevelsKnown, &samples);
  followSamples(before, now, of_new, kLevelsNew, &samples);

  std::vector<Prediction> predictions;
  std::size_t first = 0;
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    std::size_t last = first;
    while (last < samples.owner.size() && samples.owner[last] == k) ++last;
    predictions.push_back(fitSamples(samples, k, first, last));
    first = last;
  }
  return predictions;
}

bool LineTracker::isSameLine(const Edge& a, const Edge& b, double max_distance_px) const {
  if (liesAside(a.normal(), b.start, b.end, focal_px_, max_distance_px)) return false;
  const Overlap overlap = overlapOf(ArcFrame(a.start, a.end), b.start, b.end, focal_px_);
  return overlap.share >= kSameOverlap && overlap.largest_px <= max_distance_px;
}

// Mutual best partners: a line and a detection that each have no better one.
std::vector<LineTracker::Match> LineTracker::match(const std::vector<Prediction>& predictions,
                                                   const std::vector<LineSegment>& segments) const {
  constexpr double kNoCost = std::numeric_limits<double>::infinity();
  std::vector<Match> matches(predictions.size());
  std::vector<int> best_of_segment(segments.size(), -1);
  std::vector<double> cost_of_line(predictions.size(), kNoCost);
  std::vector<double> cost_of_segment(segments.size(), kNoCost);
  for (std::size_t k = 0; k < predictions.size(); ++k) {
    if (!predictions[k].ok) continue;
    const ArcFrame arc(predictions[k].start, predictions[k].end);
    for (std::size_t s = 0; s < segments.size(); ++s) {
      const LineSegment& segment = segments[s];
      if (liesAside(arc.n, segment.start, segment.end, focal_px_, kMaxDistancePx)) continue;
      const Overlap overlap = overlapOf(arc, segment.start, segment.end, focal_px_);
      if (overlap.share < kMinOverlap || overlap.largest_px > kMaxDistancePx ||
          overlap.angle > kMaxAngle) {
        continue;
      }
      const double cost = overlap.distance_px / kMaxDistancePx + (1.0 - overlap.share);
      if (cost < cost_of_line[k]) {
        cost_of_line[k] = cost;
        matches[k] = {static_cast<int>(s), overlap};
      }
      if (cost < cost_of_segment[s]) {
        cost_of_segment[s] = cost;
        best_of_segment[s] = static_cast<int>(k);
      }
    }
  }
  for (std::size_t k = 0; k < matches.size(); ++k) {
    const int s = matches[k].segment;
    if (s >= 0 && best_of_segment[s] != static_cast<int>(k)) {
      matches[k] = Match();
    }
  }
  return matches;
}

// Moves a track to this image: from the prediction and, where there is one, the detection `match`,
// refitted to the edge. False where the line is not found; `track` is then useless.
bool LineTracker::follow(const ImagePyramid& now, const RotationPrior& prior,
                         const Prediction& prediction, const Match& match,
                         const std::vector<LineSegment>& segments, LineTrack* track) const {
  const bool matched = match.segment >= 0;
  const Eigen::Vector3d normal_before = track->edge.normal();
  Eigen::Vector3d start = prediction.start, end = prediction.end;
  if (matched) {
    // As far as either of them reaches; the refit cuts off what is no edge.
    const LineSegment& segment = segments[match.segment];
    const ArcFrame arc(start, end);
    const double x0 = std::min(arc.x_start, arc.alongOf(segment.start));
    const double x1 = std::max(arc.x_end, arc.alongOf(segment.end));
    start = arc.direction(x0, 0.0);
    end = arc.direction(x1, 0.0);
  }
  if (!refit(now, start, end, kSearchTrackedPx, &track->edge) ||
      track->edge.length_px < kShortening * options_.lines.min_length_px) {
    return false;
  }
  const Overlap moved = overlapOf(ArcFrame(prediction.start, prediction.end), track->edge.start,
                                  track->edge.end, focal_px_);
  if (!(moved.share > 0.0) || moved.largest_px > kMaxJumpPx) return false;
  const double deviation = moved.distance_px / kMatchSigmaPx;
  const double certainty = std::exp(-0.5 * deviation * deviation);
  track->match_quality =
      certainty *
      (matched ? kQualityOfMatch + (1.0 - kQualityOfMatch) * std::min(1.0, match.overlap.share)
               : std::pow(kQualityOfMiss, track->missed));
  track->confidence = confidenceOf(track->edge, now.noise);
  track->normal_drift = track->edge.normal() - prior.R_now_before * normal_before;
  ++track->age;
  return true;
}

// False also for an edge that ends in the masked area.
bool LineTracker::refit(const ImagePyramid& now, const Eigen::Vector3d& start,
                        const Eigen::Vector3d& end, double search_px, Edge* edge) const {
  return fitEdge(now.level(0), lens_, start, end, search_px, now.noise, kLeastSupport,
                 kMaxRefitRmsPx, edge) &&
         !isMasked(options_.mask, toPoint(edge->start_pixel)) &&
         !isMasked(options_.mask, toPoint(edge->end_pixel));
}

bool LineTracker::isTaken(const Edge& edge, double distance_px) const {
  return std::any_of(tracks_.begin(), tracks_.end(), [&](const LineTrack& other) {
    return isSameLine(other.edge, edge, distance_px);
  });
}

// Keeps one of several tracks that ended on one edge: the one of the highest rank.
void LineTracker::keepDistinct(std::vector<LineTrack> moved, ImageReport* report) {
  std::stable_sort(moved.begin(), moved.end(),
                   [](const LineTrack& a, const LineTrack& b) { return rankOf(a) > rankOf(b); });
  tracks_.clear();
  for (const LineTrack& track : moved) {
    if (isTaken(track.edge, kSameDistancePx)) continue;
    tracks_.push_back(track);
    ++(track.missed == 0 ? report->lines_matched : report->lines_carried);
  }
}

// Adds lines for detections that are no tracked line, longest first, up to the permitted number.
void LineTracker::addNew(const ImagePyramid& now, const std::vector<LineSegment>& segments,
                         ImageReport* report) {
  const LineTrackerOptions& o = options_.lines;
  for (const LineSegment& segment : segments) {
    if (static_cast<int>(tracks_.size()) >= o.max_lines) break;
    if (segment.taken) continue;
    LineTrack track;
    if (!refit(now, segment.start, segment.end, kSearchNewPx, &track.edge) ||
        track.edge.length_px < o.min_length_px || isTaken(track.edge, kNewDistancePx)) {
      continue;
    }
    track.confidence = confidenceOf(track.edge, now.noise);
    track.id = next_id_++;
    tracks_.push_back(track);
    ++report->lines_new;
  }
}

void LineTracker::track(const ImagePyramid& before, const ImagePyramid& now,
                        const RotationPrior& prior, std::vector<LineSegment> segments,
                        const PointMotion& points, ImageReport* report) {
  if (before.empty()) tracks_.clear();
  const std::vector<Prediction> predictions = predict(before, now, prior, points);
  const std::vector<Match> matches = match(predictions, segments);
  std::vector<LineTrack> moved;
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    if (!predictions[k].ok) continue;
    LineTrack track = tracks_[k];
    const int s = matches[k].segment;
    if (s >= 0) segments[s].taken = true;
    track.missed = s >= 0 ? 0 : track.missed + 1;
    if (track.missed > kMaxMissed) continue;
    if (follow(now, prior, predictions[k], matches[k], segments, &track)) moved.push_back(track);
  }
  keepDistinct(std::move(moved), report);
  addNew(now, segments, report);
}

}  // namespace slim_init::feature_tracker_lines
