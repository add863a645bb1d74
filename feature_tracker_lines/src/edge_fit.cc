// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "edge_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "image_pyramid.h"

namespace slim_init::feature_tracker_lines {
namespace {

// Samples along an edge: every so many pixels, within bounds, of which so many have to be used.
constexpr double kSampleStepPx = 3.0;
constexpr int kMaxSamples = 40, kMinSamples = 8, kLeastUsed = 5;
constexpr int kMaxSearch = 6;  // to either side of the arc [px]
constexpr int kMaxProfile = 2 * (kMaxSearch + 2) + 1;
// A slope has to exceed its own noise by this factor, and rounding [grey levels / px].
constexpr double kSlopeSigmas = 3.0, kLeastSlope = 1.5;
// Variance of the noise of a pixel over that of a slope: mean of three pixels, difference of two of
// these means over two pixels.
constexpr double kSlopeAveraging = 6.0;
// Of two equally steep edges the nearer one is meant: a rise two pixels off counts for two thirds.
constexpr double kCentrePreference = 0.12;
constexpr double kDerivativeStep = 1e-4;  // [rad], of the numerical direction across the arc
constexpr double kInlierPx = 1.0;         // samples this close to the fit are used
constexpr double kFitScalePx = 0.3;       // Cauchy scale of the fit
constexpr int kReweightings = 4;
// Samples without edge that an edge may bridge: a crossing, a pole in front.
constexpr int kBridgedSamples = 4;

// Where the brightness rises.
struct Rise {
  bool found = false;
  double offset_px = 0.0;  // across, from the arc
  double slope = 0.0;      // [grey levels / px]
};

// The steepest rise along `across` (unit) within `search` pixels of `middle`, averaged over three
// pixels along the edge.
Rise steepestRise(const cv::Mat& grey, const Eigen::Vector2d& middle, const Eigen::Vector2d& across,
                  int search, double least_slope) {
  Rise rise;
  const int reach = search + 2;
  const double margin = reach + 2.0;
  if (!(middle.x() > margin && middle.y() > margin && middle.x() < grey.cols - 1 - margin &&
        middle.y() < grey.rows - 1 - margin)) {
    return rise;
  }
  std::array<float, kMaxProfile> profile;
  const auto ax = static_cast<float>(across.x()), ay = static_cast<float>(across.y());
  for (int j = -reach; j <= reach; ++j) {
    const float x = static_cast<float>(middle.x()) + static_cast<float>(j) * ax;
    const float y = static_cast<float>(middle.y()) + static_cast<float>(j) * ay;
    profile[j + reach] = (brightnessAt(grey, x, y) + brightnessAt(grey, x + ay, y - ax) +
                          brightnessAt(grey, x - ay, y + ax)) /
                         3.0F;
  }
  std::array<float, kMaxProfile> slope;  // valid from 1 to 2 reach - 1
  for (int j = 1; j < 2 * reach; ++j) {
    slope[j] = 0.5F * (profile[j + 1] - profile[j - 1]);
  }
  double best = 0.0;
  for (int j = 2; j < 2 * reach - 1; ++j) {
    const float here = slope[j];
    const float left = slope[j - 1];
    const float right = slope[j + 1];
    if (!(here > least_slope && here >= left && here > right)) continue;
    const int off = j - reach;
    const double value = here / (1.0 + kCentrePreference * off * off);
    if (value <= best) continue;
    best = value;
    rise.found = true;
    rise.slope = here;
    rise.offset_px = off + 0.5 * (left - right) / (left - 2.0 * here + right);
  }
  return rise;
}

// The arc in the image: pixels of samples at equal steps, with one more at each end.
struct ArcPixels {
  ArcPixels(const ArcFrame& arc_frame, const RowCamera& lens, int sample_count)
      : arc(arc_frame),
        camera(lens),
        samples(sample_count),
        step((arc_frame.x_end - arc_frame.x_start) / (sample_count - 1)) {
    for (int i = -1; i <= samples; ++i) {
      const auto at = static_cast<std::size_t>(i + 1);
      seen[at] = camera.project(arc.u + xOf(i) * arc.t, &pixel[at]);
    }
  }

  double xOf(int i) const { return arc.x_start + i * step; }

  // Jacobian of the pixel of sample i by (x, y) of the arc's frame [px / rad]. False outside the
  // image. At the image's edge the derivative is one-sided.
  bool jacobian(int i, Eigen::Matrix2d* J) const {
    const auto at = static_cast<std::size_t>(i + 1);
    if (!seen[at]) return false;
    const Eigen::Vector2d& next = seen[at + 1] ? pixel[at + 1] : pixel[at];
    const Eigen::Vector2d& last = seen[at - 1] ? pixel[at - 1] : pixel[at];
    const double dx = step * ((seen[at + 1] ? 1 : 0) + (seen[at - 1] ? 1 : 0));
    Eigen::Vector2d beside;
    if (!(dx > 0.0) || !camera.project(arc.u + xOf(i) * arc.t + kDerivativeStep * arc.n, &beside)) {
      return false;
    }
    J->col(0) = (next - last) / dx;
    J->col(1) = (beside - pixel[at]) / kDerivativeStep;
    return true;
  }

  const ArcFrame& arc;
  const RowCamera& camera;
  const int samples;
  const double step;  // [x of the arc's frame]
  std::array<Eigen::Vector2d, kMaxSamples + 2> pixel;
  std::array<bool, kMaxSamples + 2> seen{};
};

// Places on the edge, in the arc's frame.
struct EdgePoints {
  explicit EdgePoints(int samples) : x(samples), y(samples), slope(samples) {}
  int count = 0;
  Eigen::ArrayXd x, y;   // the first `count` are set
  Eigen::ArrayXd slope;  // of the brightness [grey levels / px]
  std::array<int, kMaxSamples> sample{};

  double residual(int k, const StraightFit& fit) const {
    return y[k] - fit.offset - fit.slope * x[k];
  }
};

// Moves every sample across the arc to the steepest rise in brightness.
EdgePoints findEdgePoints(const cv::Mat& grey, const ArcPixels& arc, int search,
                          double least_slope) {
  EdgePoints points(arc.samples);
  for (int i = 0; i < arc.samples; ++i) {
    Eigen::Matrix2d J;
    if (!arc.jacobian(i, &J)) continue;
    const Eigen::Vector2d along = J.col(0).normalized();
    const Eigen::Vector2d across(-along.y(), along.x());
    const Rise rise = steepestRise(grey, arc.pixel[i + 1], across, search, least_slope);
    if (!rise.found) continue;
    const Eigen::Vector2d moved = J.inverse() * (rise.offset_px * across);
    if (!moved.allFinite()) continue;
    points.x[points.count] = arc.xOf(i) + moved.x();
    points.y[points.count] = moved.y();
    points.slope[points.count] = rise.slope;
    points.sample[points.count] = i;
    ++points.count;
  }
  return points;
}

// A run of edge points on the fit, `first` to `last`; none: -1.
struct Stretch {
  int first = -1, last = -1;
};

// The longest stretch of points within kInlierPx of the fit whose gaps are no longer than may
// be bridged.
Stretch longestStretch(const EdgePoints& points, const StraightFit& fit, double focal_px) {
  const auto sampleOf = [&points](int k) { return points.sample[k]; };
  Stretch best, current;
  for (int k = 0; k < points.count; ++k) {
    if (std::abs(points.residual(k, fit) * focal_px) > kInlierPx) continue;
    if (current.first < 0 || sampleOf(k) - sampleOf(current.last) > kBridgedSamples + 1) {
      current.first = k;
    }
    current.last = k;
    if (best.first < 0 ||
        sampleOf(k) - sampleOf(current.first) > sampleOf(best.last) - sampleOf(best.first)) {
      best = current;
    }
  }
  return best;
}

// Support, rms and contrast of an edge from the points of a stretch; returns how many are used.
int measureEdge(const EdgePoints& points, const StraightFit& fit, const Stretch& stretch,
                double focal_px, Edge* edge) {
  double squares = 0.0;
  std::vector<double> slopes;
  for (int k = stretch.first; k <= stretch.last; ++k) {
    const double residual_px = points.residual(k, fit) * focal_px;
    if (std::abs(residual_px) > kInlierPx) continue;
    squares += residual_px * residual_px;
    slopes.push_back(points.slope[k]);
  }
  const int samples = points.sample[stretch.last] - points.sample[stretch.first] + 1;
  const auto count = static_cast<int>(slopes.size());
  edge->support = static_cast<double>(count) / samples;
  edge->rms_px = std::sqrt(squares / count);
  const auto middle = slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2);
  std::nth_element(slopes.begin(), middle, slopes.end());
  edge->contrast = *middle;
  return count;
}

}  // namespace

ArcFrame::ArcFrame(const Eigen::Vector3d& start, const Eigen::Vector3d& end)
    : u((start + end).normalized()), n(start.cross(end).normalized()) {
  t = n.cross(u);
  x_start = alongOf(start);
  x_end = alongOf(end);
}

StraightFit fitStraight(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y, double scale) {
  StraightFit fit;
  Eigen::ArrayXd weight = Eigen::ArrayXd::Ones(x.size());
  for (int round = 0; round <= kReweightings; ++round) {
    const double w = weight.sum();
    if (!(w > 0.0)) return fit;
    const double x_mean = (weight * x).sum() / w, y_mean = (weight * y).sum() / w;
    const double xx = (weight * (x - x_mean).square()).sum();
    const double xy = (weight * (x - x_mean) * (y - y_mean)).sum();
    if (!(xx > 0.0)) return fit;
    fit.slope = xy / xx;
    fit.offset = y_mean - fit.slope * x_mean;
    weight = 1.0 / (1.0 + ((y - fit.offset - fit.slope * x) / scale).square());
  }
  fit.ok = std::isfinite(fit.offset) && std::isfinite(fit.slope);
  return fit;
}

Eigen::Vector3d Edge::normal() const { return start.cross(end).normalized(); }

bool fitEdge(const cv::Mat& grey, const RowCamera& camera, const Eigen::Vector3d& start,
             const Eigen::Vector3d& end, double search_px, double noise, double min_support,
             double max_rms_px, Edge* edge) {
  const ArcFrame arc(start, end);
  if (!arc.u.allFinite() || !arc.n.allFinite() || !(arc.x_end > arc.x_start)) return false;
  const double focal = camera.focalPx();
  const int search = std::clamp(static_cast<int>(std::ceil(search_px)), 1, kMaxSearch);
  const int samples =
      std::clamp(static_cast<int>((arc.x_end - arc.x_start) * focal / kSampleStepPx), kMinSamples,
                 kMaxSamples);
  const double least_slope =
      std::max(kLeastSlope, kSlopeSigmas * noise / std::sqrt(kSlopeAveraging));

  const EdgePoints points =
      findEdgePoints(grey, ArcPixels(arc, camera, samples), search, least_slope);
  if (points.count < kLeastUsed) return false;
  const StraightFit fit =
      fitStraight(points.x.head(points.count), points.y.head(points.count), kFitScalePx / focal);
  if (!fit.ok) return false;
  const Stretch stretch = longestStretch(points, fit, focal);
  if (stretch.first < 0) return false;
  const int used = measureEdge(points, fit, stretch, focal, edge);
  if (used < kLeastUsed || edge->support < min_support || edge->rms_px > max_rms_px) return false;

  const auto onFit = [&](int k) {
    return arc.direction(points.x[k], fit.offset + fit.slope * points.x[k]);
  };
  edge->start = onFit(stretch.first);
  edge->end = onFit(stretch.last);
  if (!camera.project(edge->start, &edge->start_pixel) ||
      !camera.project(edge->end, &edge->end_pixel)) {
    return false;
  }
  edge->length_px = (edge->end_pixel - edge->start_pixel).norm();
  return true;
}

}  // namespace slim_init::feature_tracker_lines
