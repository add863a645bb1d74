// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the point and the line tracker share of an image: its pyramid, built once, and its noise.
#pragma once

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

namespace slim_init::feature_tracker_lines {

/// An image, its pyramid with derivatives and the noise of its pixels.
struct ImagePyramid {
  /// As cv::buildOpticalFlowPyramid() makes it, with derivatives: image and derivative of every
  /// level in turn. Each is padded, so that KLT windows may reach over the edge.
  std::vector<cv::Mat> pyramid;
  int max_level = 0;   ///< last level that exists; small images have few
  int halvings = 0;    ///< of the sensor's image until level 0
  int window_px = 0;   ///< widest KLT window that the padding is made for
  double noise = 0.0;  ///< of level 0, see levelNoise() [grey levels]

  bool empty() const { return pyramid.empty(); }
  /// This pyramid from level l on, sharing its memory; empty where it has no such level.
  ImagePyramid from(int l) const;
  /// Scharr derivatives of level l (CV_16SC2), 32 times those per pixel of that level.
  const cv::Mat& derivative(int l) const { return pyramid[2 * l + 1]; }
  /// Level 0 is the image itself (CV_8UC1); a pixel (x, y) of level l lies at (x, y) 2^l of it.
  const cv::Mat& level(int l) const { return pyramid[2 * l]; }
};

/// Bilinear brightness of a CV_8UC1 image; the caller keeps the position inside.
inline float brightnessAt(const cv::Mat& grey, float x, float y) {
  const int xi = static_cast<int>(x), yi = static_cast<int>(y);
  const float ax = x - static_cast<float>(xi), ay = y - static_cast<float>(yi);
  const uchar* top = grey.ptr<uchar>(yi) + xi;
  const uchar* bottom = grey.ptr<uchar>(yi + 1) + xi;
  const float upper = static_cast<float>(top[0]) + ax * static_cast<float>(top[1] - top[0]);
  const float lower =
      static_cast<float>(bottom[0]) + ax * static_cast<float>(bottom[1] - bottom[0]);
  return upper + ay * (lower - upper);
}

/// Whether a mask (empty: none) leaves out a pixel, which may lie half a pixel beyond the
/// outermost.
inline bool isMasked(const cv::Mat& mask, const cv::Point2f& pixel) {
  return !mask.empty() && mask.at<uchar>(std::clamp(cvRound(pixel.y), 0, mask.rows - 1),
                                         std::clamp(cvRound(pixel.x), 0, mask.cols - 1)) == 0;
}

/// Builds the pyramid of a CV_8UC1 image for KLT windows of up to `window_px`; copies the image.
/// Level 0 is the image after `halvings` halvings.
void buildImagePyramid(const cv::Mat& grey, int window_px, int levels, int halvings,
                       ImagePyramid* out);

/// Multiplies the grey levels of an image, and of what shares its memory, row by row: the image is
/// divided into as many equal bands as there are factors. Each holds at the middle of its band,
/// between the middles the factor changes linearly. A single one holds everywhere.
void scaleRows(const std::vector<double>& factors, ImagePyramid* image);

/// Halvings after which an image has at most twice the pixels of 752 x 480. Bounds in pixels are
/// those of such an image, and so is the time.
int halvingsFor(cv::Size image_size);

/// What white noise of standard deviation `noise` in the sensor's image is worth after `halvings`
/// halvings [grey levels], at least kLeastNoise: the standard deviation of white noise that makes
/// corners as strong. The halved noise itself is smaller by a fifth, but it is correlated.
double levelNoise(double noise, int halvings);

/// Standard deviation of the pixel noise [grey levels], at least kLeastNoise: the tenth percentile
/// over image blocks of the response to a filter that no linear or bilinear brightness passes
/// (Immerkaer 1996). Blocks that are clipped at black or white show less of it and are left out,
/// unless all are.
double measureNoise(const cv::Mat& grey);

/// Rounding to whole grey levels alone is 0.29.
inline constexpr double kLeastNoise = 0.3;

}  // namespace slim_init::feature_tracker_lines
