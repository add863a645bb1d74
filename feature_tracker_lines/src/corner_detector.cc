// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "corner_detector.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace slim_init::feature_tracker_lines {
namespace {

// Side of a cell [px]: two or three corners at the default distance between points.
constexpr int kCellPx = 48;
constexpr int kHalfBlock = kCornerBlock / 2;
// Of a derivative as OpenCV stores it: Scharr's weights 3, 10, 3 over two pixels.
constexpr float kDerivativeUnit = 1.0F / 32.0F;
// A cell is searched if more than one in so many of its pixels, sampled at this step, are free.
constexpr int kLeastFree = 8, kFreeStep = 4;

bool hasRoom(const cv::Mat& mask, const cv::Rect& area) {
  int free = 0, seen = 0;
  for (int y = area.y + kFreeStep / 2; y < area.br().y; y += kFreeStep) {
    const uchar* row = mask.ptr<uchar>(y);
    for (int x = area.x + kFreeStep / 2; x < area.br().x; x += kFreeStep, ++seen) {
      free += row[x] != 0 ? 1 : 0;
    }
  }
  return kLeastFree * free > seen;
}

}  // namespace

double cornerEigenvalue(const cv::Mat& derivative, int x, int y) {
  double xx = 0.0, xy = 0.0, yy = 0.0;
  const auto stride = static_cast<std::ptrdiff_t>(derivative.step1());
  for (int j = y - kHalfBlock; j <= y + kHalfBlock; ++j) {
    for (int i = x - kHalfBlock; i <= x + kHalfBlock; ++i) {
      const short* d = derivative.ptr<short>(0) + j * stride + 2 * i;
      const double gx = kDerivativeUnit * d[0], gy = kDerivativeUnit * d[1];
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  }
  return (0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy)) / (kCornerBlock * kCornerBlock);
}

CornerDetector::CornerDetector(cv::Size image_size, double min_distance_px, double border_px)
    : min_distance_(static_cast<int>(std::ceil(min_distance_px))) {
  const int border = static_cast<int>(std::ceil(border_px));
  const cv::Rect usable(border, border, image_size.width - 2 * border,
                        image_size.height - 2 * border);
  for (int y = usable.y; y < usable.br().y; y += kCellPx) {
    for (int x = usable.x; x < usable.br().x; x += kCellPx) {
      cells_.push_back({cv::Rect(x, y, kCellPx, kCellPx) & usable, -1});
    }
  }
}

void CornerDetector::reset() {
  calls_ = 0;
  for (Cell& cell : cells_) cell.last_seen = -1;
}

// Sums of the products xx, xy and yy of the derivatives over kCornerBlock columns: a plane each,
// of the area with one pixel around it and half a block more above and below.
void CornerDetector::sumRows(const cv::Mat& derivative, const cv::Rect& area) {
  // Up to three pixels past the edge of the image are read, which the padding of the pyramid
  // covers.
  const int cols = area.width + 2;
  const int wide_rows = area.height + 2 + 2 * kHalfBlock, wide_cols = cols + 2 * kHalfBlock;
  const auto plane = static_cast<std::size_t>(cols) * static_cast<std::size_t>(wide_rows);
  sums_.resize(3 * plane);
  products_.resize(3 * static_cast<std::size_t>(wide_cols));
  const auto stride = static_cast<std::ptrdiff_t>(derivative.step1());
  for (int j = 0; j < wide_rows; ++j) {
    const short* d = derivative.ptr<short>(0) + (area.y - 1 - kHalfBlock + j) * stride +
                     2 * (area.x - 1 - kHalfBlock);
    float* xx = products_.data();
    float* xy = xx + wide_cols;
    float* yy = xy + wide_cols;
    for (int i = 0; i < wide_cols; ++i) {
      const float gx = kDerivativeUnit * static_cast<float>(d[2 * i]);
      const float gy = kDerivativeUnit * static_cast<float>(d[2 * i + 1]);
      xx[i] = gx * gx;
      xy[i] = gx * gy;
      yy[i] = gy * gy;
    }
    for (int p = 0; p < 3; ++p) {
      const float* from = products_.data() + p * wide_cols;
      float* to = sums_.data() + static_cast<std::size_t>(p) * plane + j * cols;
      static_assert(kCornerBlock == 5, "five terms below");
      for (int i = 0; i < cols; ++i) {
        to[i] = from[i] + from[i + 1] + from[i + 2] + from[i + 3] + from[i + 4];
      }
    }
  }
}

// Smaller eigenvalue of the structure tensor in the area and one pixel around it; zero on edges.
void CornerDetector::computeResponses(const cv::Rect& area) {
  const int rows = area.height + 2, cols = area.width + 2;
  const auto plane = sums_.size() / 3;
  responses_.resize(static_cast<std::size_t>(cols) * static_cast<std::size_t>(rows));
  constexpr float kMean = 1.0F / (kCornerBlock * kCornerBlock);
  constexpr auto kRatio = static_cast<float>(kLeastCornerRatio);
  using Row = Eigen::Map<const Eigen::ArrayXf>;
  const auto column = [cols](const float* s) {
    return Row(s, cols) + Row(s + cols, cols) + Row(s + 2 * cols, cols) + Row(s + 3 * cols, cols) +
           Row(s + 4 * cols, cols);
  };
  Eigen::ArrayXf a(cols), b(cols), c(cols), root(cols);
  for (int j = 0; j < rows; ++j) {
    const float* xx = sums_.data() + j * cols;
    a = column(xx);
    b = column(xx + plane);
    c = column(xx + 2 * plane);
    root = (0.25F * (a - c).square() + b.square()).sqrt();
    // Half the trace less and plus the root are the two eigenvalues.
    a = 0.5F * (a + c);
    Eigen::Map<Eigen::ArrayXf>(responses_.data() + j * cols, cols) =
        (a - root > kRatio * (a + root)).select(kMean * (a - root), 0.0F);
  }
}

// Appends the local maxima in `area` that are free, strong enough and no edges.
void CornerDetector::searchCell(const cv::Mat& derivative, const cv::Mat& mask,
                                const cv::Rect& area, float min_eigenvalue,
                                std::vector<Corner>* found) {
  sumRows(derivative, area);
  computeResponses(area);
  const int rows = area.height + 2, cols = area.width + 2;
  for (int j = 1; j + 1 < rows; ++j) {
    const float* here = responses_.data() + j * cols;
    const float* above = here - cols;
    const float* below = here + cols;
    const uchar* free = mask.ptr<uchar>(area.y + j - 1) + area.x - 1;
    for (int i = 1; i + 1 < cols; ++i) {
      const float value = here[i];
      if (!(value > min_eigenvalue) || free[i] == 0) continue;
      // Of equals (a flat top) the first in reading order.
      if (value > above[i - 1] && value > above[i] && value > above[i + 1] && value > here[i - 1] &&
          value >= here[i + 1] && value >= below[i - 1] && value >= below[i] &&
          value >= below[i + 1]) {
        found->push_back({value, area.x + i - 1, area.y + j - 1});
      }
    }
  }
}

void CornerDetector::detect(const cv::Mat& derivative, double min_eigenvalue, int count,
                            int max_cells, cv::Mat* mask, std::vector<cv::Point2f>* corners) {
  if (count <= 0) return;
  ++calls_;
  std::vector<Cell*> order;
  for (Cell& cell : cells_) {
    if (hasRoom(*mask, cell.area)) order.push_back(&cell);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const Cell* a, const Cell* b) { return a->last_seen < b->last_seen; });
  if (static_cast<int>(order.size()) > max_cells) order.resize(static_cast<std::size_t>(max_cells));

  std::vector<Corner> found;
  for (Cell* cell : order) {
    cell->last_seen = calls_;
    searchCell(derivative, *mask, cell->area, static_cast<float>(min_eigenvalue), &found);
  }
  std::sort(found.begin(), found.end(), [](const Corner& a, const Corner& b) {
    if (a.eigenvalue != b.eigenvalue) return a.eigenvalue > b.eigenvalue;
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
  for (const Corner& corner : found) {
    if (count <= 0) break;
    if (mask->at<uchar>(corner.y, corner.x) == 0) continue;
    corners->emplace_back(static_cast<float>(corner.x), static_cast<float>(corner.y));
    cv::circle(*mask, cv::Point(corner.x, corner.y), min_distance_, cv::Scalar(0), cv::FILLED);
    --count;
  }
}

}  // namespace slim_init::feature_tracker_lines
