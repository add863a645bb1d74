// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "image_pyramid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace slim_init::feature_tracker_lines {
namespace {

// Side of a block of measureNoise() [px].
constexpr int kBlock = 16;
// Every other block in both directions: a quarter of the pixels is enough.
constexpr int kBlockStep = 2 * kBlock;
constexpr int kDark = 3, kBright = 252;  // [grey levels]; beyond, the sensor clips
// Standard deviation of the filter's response to unit noise: the root of its squared coefficients'
// sum, 36.
constexpr double kFilterGain = 6.0;
// Most pixels of an image that is tracked as it is.
constexpr std::int64_t kMostPixels = 2 * 752 * 480;
// levelNoise() of unit noise after one halving and after two; from there on it halves.
constexpr double kOneHalving = 0.345, kTwoHalvings = 0.155;

void buildLevels(const cv::Mat& base, int levels, ImagePyramid* out) {
  // Not the input's memory: the caller may use it again for the next image.
  out->max_level =
      cv::buildOpticalFlowPyramid(base, out->pyramid, cv::Size(out->window_px, out->window_px),
                                  levels, true, cv::BORDER_REFLECT_101, cv::BORDER_CONSTANT, false);
}

}  // namespace

ImagePyramid ImagePyramid::from(int l) const {
  ImagePyramid upper;
  if (l > max_level || empty()) return upper;
  upper.pyramid.assign(pyramid.begin() + 2 * l, pyramid.end());
  upper.max_level = max_level - l;
  upper.halvings = halvings + l;
  upper.window_px = window_px;
  upper.noise =
      std::max(noise * (levelNoise(1e3, upper.halvings) / levelNoise(1e3, halvings)), kLeastNoise);
  return upper;
}

int halvingsFor(cv::Size image_size) {
  std::int64_t pixels = static_cast<std::int64_t>(image_size.width) * image_size.height;
  int halvings = 0;
  for (; pixels > kMostPixels; pixels /= 4) ++halvings;
  return halvings;
}

double levelNoise(double noise, int halvings) {
  const double factor = halvings < 1    ? 1.0
                        : halvings == 1 ? kOneHalving
                                        : std::ldexp(kTwoHalvings, 2 - halvings);
  return std::max(factor * noise, kLeastNoise);
}

void buildImagePyramid(const cv::Mat& grey, int window_px, int levels, int halvings,
                       ImagePyramid* out) {
  cv::Mat base = grey;
  for (int i = 0; i < halvings; ++i) {
    cv::Mat half;
    cv::pyrDown(base, half);
    base = half;
  }
  out->halvings = halvings;
  out->window_px = window_px;
  buildLevels(base, levels, out);
  out->noise = levelNoise(measureNoise(grey), halvings);
}

void scaleRows(const std::vector<double>& factors, ImagePyramid* image) {
  const cv::Mat& grey = image->level(0);
  cv::Mat scaled(grey.size(), CV_8UC1);
  const auto last = static_cast<double>(factors.size() - 1);
  double sum = 0.0;
  for (int y = 0; y < grey.rows; ++y) {
    const double band = std::clamp((y + 0.5) / grey.rows * (last + 1.0) - 0.5, 0.0, last);
    const auto above = static_cast<std::size_t>(band);
    const std::size_t below = std::min(above + 1, factors.size() - 1);
    const double factor =
        factors[above] + (band - static_cast<double>(above)) * (factors[below] - factors[above]);
    cv::Mat row = scaled.row(y);
    grey.row(y).convertTo(row, CV_8U, factor);
    sum += factor;
  }
  image->noise = std::max(sum / grey.rows * image->noise, kLeastNoise);
  buildLevels(scaled, image->max_level, image);
}

double measureNoise(const cv::Mat& grey) {
  std::vector<double> variances, clipped;  // of the blocks
  for (int y0 = 1; y0 + kBlock < grey.rows; y0 += kBlockStep) {
    for (int x0 = 1; x0 + kBlock < grey.cols; x0 += kBlockStep) {
      int sum = 0, sum_squares = 0, darkest = 255, brightest = 0;
      for (int y = y0; y < y0 + kBlock; ++y) {
        const uchar* above = grey.ptr<uchar>(y - 1) + x0;
        const uchar* here = grey.ptr<uchar>(y) + x0;
        const uchar* below = grey.ptr<uchar>(y + 1) + x0;
        for (int x = 0; x < kBlock; ++x) {
          const int response = 4 * here[x] - 2 * (above[x] + below[x] + here[x - 1] + here[x + 1]) +
                               above[x - 1] + above[x + 1] + below[x - 1] + below[x + 1];
          sum += response;
          sum_squares += response * response;
          darkest = std::min<int>(darkest, here[x]);
          brightest = std::max<int>(brightest, here[x]);
        }
      }
      constexpr double kCount = kBlock * kBlock;
      (darkest < kDark || brightest > kBright ? clipped : variances)
          .push_back(sum_squares / kCount - (sum / kCount) * (sum / kCount));
    }
  }
  // At night, or under a lens cap, every block is clipped and still noisy.
  if (variances.empty()) variances.swap(clipped);
  if (variances.empty()) return kLeastNoise;
  const auto tenth = variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 10);
  std::nth_element(variances.begin(), tenth, variances.end());
  return std::max(std::sqrt(*tenth) / kFilterGain, kLeastNoise);
}

}  // namespace slim_init::feature_tracker_lines
