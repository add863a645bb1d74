// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "edge_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace slim_init::feature_tracker_lines {
namespace {

constexpr int kMaxSamples = 40, kMinSamples = 8, kLeastUsed = 5;
constexpr double kSampleStepPx = 3.0;
constexpr int kMaxSearch = 6;  // [px]
constexpr int kMaxProfile = 2 * (kMaxSearch + 2) + 1;
// A slope has to stand out of its own noise by this factor, and of rounding.
constexpr double kSlopeSigmas = 3.0, kLeastSlope = 1.5;
// Of two edges as steep the nearer one is meant: a rise two pixels off counts for two thirds.
constexpr double kCentrePreference = 0.12;
constexpr double kInlierPx = 1.0, kFitScalePx = 0.3;
constexpr int kReweightings = 4;
// Samples without edge that an edge may bridge: a crossing, a pole in front.
constexpr int kBridgedSamples = 4;

// Bilinear brightness; the caller keeps the position inside.
inline float brightness(const cv::Mat& grey, float x, float y) {
  const int xi = static_cast<int>(x), yi = static_cast<int>(y);
  const float ax = x - static_cast<float>(xi), ay = y - static_cast<float>(yi);
  const uchar* top = grey.ptr<uchar>(yi) + xi;
  const uchar* bottom = grey.ptr<uchar>(yi + 1) + xi;
  const float upper = static_cast<float>(top[0]) + ax * static_cast<float>(top[1] - top[0]);
  const float lower =
      static_cast<float>(bottom[0]) + ax * static_cast<float>(bottom[1] - bottom[0]);
  return upper + ay * (lower - upper);
}

struct Rise {
  bool found = false;
  double offset_px = 0.0;
  double slope = 0.0;
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
    profile[static_cast<std::size_t>(j + reach)] =
        (brightness(grey, x, y) + brightness(grey, x + ay, y - ax) +
         brightness(grey, x - ay, y + ax)) /
        3.0F;
  }
  std::array<float, kMaxProfile> slope;  // valid from 1 to 2 reach - 1
  for (int j = 1; j < 2 * reach; ++j) {
    slope[static_cast<std::size_t>(j)] = 0.5F * (profile[static_cast<std::size_t>(j + 1)] -
                                                 profile[static_cast<std::size_t>(j - 1)]);
  }
  double best = 0.0;
  for (int j = 2; j < 2 * reach - 1; ++j) {
    const float here = slope[static_cast<std::size_t>(j)];
    const float left = slope[static_cast<std::size_t>(j - 1)];
    const float right = slope[static_cast<std::size_t>(j + 1)];
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

bool fitEdge(const cv::Mat& grey, const Camera& camera, const Eigen::Vector3d& start,
             const Eigen::Vector3d& end, double search_px, double noise, double min_support,
             double max_rms_px, Edge* edge) {
  const ArcFrame arc(start, end);
  if (!arc.u.allFinite() || !arc.n.allFinite() || !(arc.x_end > arc.x_start)) return false;
  const double focal = camera.focalPx();
  const int search = std::clamp(static_cast<int>(std::ceil(search_px)), 1, kMaxSearch);
  const int samples =
      std::clamp(static_cast<int>((arc.x_end - arc.x_start) * focal / kSampleStepPx), kMinSamples,
                 kMaxSamples);
  // Mean of three pixels, difference of two of these over two pixels.
  const double least_slope = std::max(kLeastSlope, kSlopeSigmas * noise / std::sqrt(6.0));

  // One more at each end for the direction of the curve in the image.
  std::array<Eigen::Vector2d, kMaxSamples + 2> pixel;
  std::array<bool, kMaxSamples + 2> seen{};
  const double step = (arc.x_end - arc.x_start) / (samples - 1);
  for (int i = 0; i < samples + 2; ++i) {
    const double x = arc.x_start + (i - 1) * step;
    seen[static_cast<std::size_t>(i)] =
        camera.project(arc.u + x * arc.t, &pixel[static_cast<std::size_t>(i)]);
  }
  constexpr double kTiny = 1e-4;  // [rad]
  Eigen::ArrayXd x(samples), y(samples), slope(samples);
  std::array<int, kMaxSamples> place{};  // sample number of each one found
  int found = 0;
  for (int i = 0; i < samples; ++i) {
    const auto at = static_cast<std::size_t>(i + 1);
    if (!seen[at]) continue;
    // Near the image's edge from one side only.
    const Eigen::Vector2d& next = seen[at + 1] ? pixel[at + 1] : pixel[at];
    const Eigen::Vector2d& last = seen[at - 1] ? pixel[at - 1] : pixel[at];
    const double dx = step * ((seen[at + 1] ? 1 : 0) + (seen[at - 1] ? 1 : 0));
    if (!(dx > 0.0)) continue;
    const double x_here = arc.x_start + i * step;
    Eigen::Vector2d beside;
    if (!camera.project(arc.u + x_here * arc.t + kTiny * arc.n, &beside)) continue;
    Eigen::Matrix2d J;  // of the pixel by (x, y)
    J.col(0) = (next - last) / dx;
    J.col(1) = (beside - pixel[at]) / kTiny;
    const Eigen::Vector2d along = J.col(0).normalized();
    const Eigen::Vector2d across(-along.y(), along.x());
    const Rise rise = steepestRise(grey, pixel[at], across, search, least_slope);
    if (!rise.found) continue;
    const Eigen::Vector2d moved = J.inverse() * (rise.offset_px * across);
    if (!moved.allFinite()) continue;
    x[found] = x_here + moved.x();
    y[found] = moved.y();
    slope[found] = rise.slope;
    place[static_cast<std::size_t>(found)] = i;
    ++found;
  }
  if (found < kLeastUsed) return false;

  const StraightFit fit = fitStraight(x.head(found), y.head(found), kFitScalePx / focal);
  if (!fit.ok) return false;

  // The longest stretch of samples on the line.
  int best_first = -1, best_last = -1, first = -1, last = -1;
  std::array<bool, kMaxSamples> used{};
  for (int k = 0; k < found; ++k) {
    const double residual_px = (y[k] - fit.offset - fit.slope * x[k]) * focal;
    if (std::abs(residual_px) > kInlierPx) continue;
    used[static_cast<std::size_t>(k)] = true;
    const int here = place[static_cast<std::size_t>(k)];
    if (first < 0 || here - place[static_cast<std::size_t>(last)] > kBridgedSamples + 1) first = k;
    last = k;
    if (best_first < 0 || here - place[static_cast<std::size_t>(first)] >
                              place[static_cast<std::size_t>(best_last)] -
                                  place[static_cast<std::size_t>(best_first)]) {
      best_first = first;
      best_last = k;
    }
  }
  if (best_first < 0) return false;
  int count = 0;
  double squares = 0.0;
  std::vector<double> slopes;
  for (int k = best_first; k <= best_last; ++k) {
    if (!used[static_cast<std::size_t>(k)]) continue;
    ++count;
    squares += std::pow((y[k] - fit.offset - fit.slope * x[k]) * focal, 2);
    slopes.push_back(slope[k]);
  }
  const int stretch =
      place[static_cast<std::size_t>(best_last)] - place[static_cast<std::size_t>(best_first)] + 1;
  edge->support = static_cast<double>(count) / stretch;
  edge->rms_px = std::sqrt(squares / std::max(count, 1));
  if (count < kLeastUsed || edge->support < min_support || edge->rms_px > max_rms_px) return false;
  const auto middle = slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2);
  std::nth_element(slopes.begin(), middle, slopes.end());
  edge->contrast = *middle;
  edge->start = arc.direction(x[best_first], fit.offset + fit.slope * x[best_first]);
  edge->end = arc.direction(x[best_last], fit.offset + fit.slope * x[best_last]);
  if (!camera.project(edge->start, &edge->start_pixel) ||
      !camera.project(edge->end, &edge->end_pixel)) {
    return false;
  }
  edge->length_px = (edge->end_pixel - edge->start_pixel).norm();
  return true;
}

}  // namespace slim_init::feature_tracker_lines
