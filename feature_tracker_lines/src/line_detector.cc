// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "line_detector.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace slim_init::feature_tracker_lines {
namespace {

// Of a derivative as OpenCV stores it: Scharr's weights 3, 10, 3 over two pixels.
constexpr double kDerivativeUnit = 32.0;
// Least |gx| + |gy| of an edge [grey levels / px], and in standard deviations of the noise of the
// full image, which is a seventh of that in a derivative of level 1.
constexpr double kLeastGradient = 4.0, kLeastNoises = 1.0;
// A segment starts where the edge is steeper by this factor, and in one of so many rows (columns
// for an edge that lies flat) only: one that is long enough crosses several of them.
constexpr double kSeedFactor = 1.5;
constexpr int kSeedStep = 4;
// Cosine of the largest angle, 20 degrees, between the gradient at a pixel and the mean one of its
// segment: less than a corner, more than the bend that a lens gives to a straight edge.
constexpr float kLeastCosine = 0.94F;
// Pixels without edge that a segment may bridge. With two, bricks of one row become one line.
constexpr int kBridgedPx = 1;
// Weight of a pixel in the running position of the edge.
constexpr float kPixelWeight = 0.5F;

}  // namespace

// A segment while it grows.
struct LineDetector::Walk {
  float gx = 0.0F, gy = 0.0F;  // sum of the gradients on it
  cv::Point seed;
  cv::Point2f ends[2];

  // Brighter to the right. The ends are pixels of the edge and no ends of a straight line fitted to
  // it: what is straight in space is curved by the lens, and its ends tell where it lies.
  cv::Vec4f segment() const {
    const cv::Point2f &a = ends[0], &b = ends[1], along = b - a;
    if (along.x * gy - along.y * gx < 0.0F) return {b.x, b.y, a.x, a.y};
    return {a.x, a.y, b.x, b.y};
  }
};

// Pixels whose gradient is steeper than at both neighbours across the edge. Without branches, which
// would be taken at random.
void LineDetector::findRidges(const cv::Mat& derivative, int least) {
  const int rows = derivative.rows, cols = derivative.cols;
  magnitude_.create(rows, cols, CV_16SC1);
  upright_.create(rows, cols, CV_16SC1);
  ridge_.create(rows, cols, CV_8UC1);
  ridge_.setTo(0);
  for (int y = 0; y < rows; ++y) {
    const short* d = derivative.ptr<short>(y);
    short* m = magnitude_.ptr<short>(y);
    short* upright = upright_.ptr<short>(y);
    for (int x = 0; x < cols; ++x) {
      const auto gx = static_cast<short>(std::abs(d[2 * x]));
      const auto gy = static_cast<short>(std::abs(d[2 * x + 1]));
      m[x] = static_cast<short>(gx + gy);
      upright[x] = static_cast<short>(gx >= gy ? 1 : 0);
    }
  }
  for (int y = 1; y + 1 < rows; ++y) {
    const short* here = magnitude_.ptr<short>(y);
    const short* above = magnitude_.ptr<short>(y - 1);
    const short* below = magnitude_.ptr<short>(y + 1);
    const short* upright = upright_.ptr<short>(y);
    uchar* ridge = ridge_.ptr<uchar>(y);
    for (int x = 1; x + 1 < cols; ++x) {
      const short m = here[x], left = here[x - 1], right = here[x + 1], up = above[x],
                  down = below[x];
      const bool of_row = (m > left) & (m >= right), of_column = (m > up) & (m >= down);
      ridge[x] = static_cast<uchar>((m >= least) & (upright[x] != 0 ? of_row : of_column));
    }
  }
}

// Where a segment may start, in reading order.
void LineDetector::findSeeds(int least) {
  seeds_.clear();
  for (int y = 1; y + 1 < ridge_.rows; ++y) {
    const uchar* ridge = ridge_.ptr<uchar>(y);
    const bool row = y % kSeedStep == 0;
    for (int x = row ? 1 : kSeedStep; x + 1 < ridge_.cols; x += row ? 1 : kSeedStep) {
      if (ridge[x] == 0 || magnitude_.ptr<short>(y)[x] < least) continue;
      if (upright_.ptr<short>(y)[x] != 0 ? row : x % kSeedStep == 0) seeds_.emplace_back(x, y);
    }
  }
}

// Goes along the edge from the seed, pixel by pixel, to one side (`way` 1) or the other (-1).
void LineDetector::follow(const cv::Mat& derivative, int way, Walk* walk) {
  // Along the axis on which the edge is longer; across it at most one pixel a step.
  const bool flat = std::abs(walk->gy) >= std::abs(walk->gx);
  const int length = flat ? ridge_.cols : ridge_.rows, width = flat ? ridge_.rows : ridge_.cols;
  const int start = flat ? walk->seed.x : walk->seed.y;
  float across = static_cast<float>(flat ? walk->seed.y : walk->seed.x);
  for (int at = start + way, gap = 0; at > 0 && at + 1 < length && gap <= kBridgedPx; at += way) {
    across -= static_cast<float>(way) * (flat ? walk->gx / walk->gy : walk->gy / walk->gx);
    const int near = cvRound(across);
    if (near < 1 || near + 2 > width) break;
    const float least = kLeastCosine * std::sqrt(walk->gx * walk->gx + walk->gy * walk->gy);
    ++gap;
    // The pixel that is expected, then its neighbours, the nearer one first.
    const int side = across > static_cast<float>(near) ? 1 : -1;
    for (const int off : {0, side, -side}) {
      const int x = flat ? at : near + off, y = flat ? near + off : at;
      uchar& ridge = ridge_.ptr<uchar>(y)[x];
      if (ridge == 0) continue;
      const short* g = derivative.ptr<short>(y) + 2 * x;
      const auto gx = static_cast<float>(g[0]), gy = static_cast<float>(g[1]);
      if (walk->gx * gx + walk->gy * gy < least * std::sqrt(gx * gx + gy * gy)) continue;
      ridge = 0;
      walk->gx += gx;
      walk->gy += gy;
      across += kPixelWeight * (static_cast<float>(near + off) - across);
      const auto here = static_cast<float>(at);
      walk->ends[way > 0 ? 1 : 0] = flat ? cv::Point2f(here, across) : cv::Point2f(across, here);
      gap = 0;
      break;
    }
  }
}

void LineDetector::detect(const cv::Mat& derivative, double noise,
                          std::vector<cv::Vec4f>* segments) {
  segments->clear();
  const auto least =
      static_cast<int>(kDerivativeUnit * std::max(kLeastGradient, kLeastNoises * noise));
  findRidges(derivative, least);
  findSeeds(static_cast<int>(kSeedFactor * least));
  for (const cv::Point& seed : seeds_) {
    if (ridge_.at<uchar>(seed) == 0) continue;
    ridge_.at<uchar>(seed) = 0;
    Walk walk;
    walk.seed = walk.ends[0] = walk.ends[1] = seed;
    const auto& g = derivative.at<cv::Vec2s>(seed);
    walk.gx = g[0];
    walk.gy = g[1];
    follow(derivative, 1, &walk);
    follow(derivative, -1, &walk);
    if (!(cv::norm(walk.ends[1] - walk.ends[0]) >= min_length_)) continue;
    segments->push_back(walk.segment());
  }
}

}  // namespace slim_init::feature_tracker_lines
