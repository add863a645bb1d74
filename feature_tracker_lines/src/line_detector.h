// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Line segments from the derivatives of an image.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace slim_init::feature_tracker_lines {

/// Finds straight edges by following ridges of the gradient's magnitude: thin edges as in Canny
/// (1986), grown to segments of one direction as in the line segment detector (Grompone von Gioi et
/// al. 2010). It takes derivatives that the pyramid has in any case. Positions are good to a pixel
/// or so: LineTracker refits what it keeps.
class LineDetector {
 public:
  /// Segments shorter than `min_length_px` are left out.
  explicit LineDetector(double min_length_px) : min_length_(min_length_px) {}

  /// Segments (x1, y1, x2, y2) with the brighter side to the right of the way from 1 to 2, in no
  /// particular order. `derivative`: CV_16SC2, as in ImagePyramid; `noise`: standard deviation of
  /// the pixel noise of that image [grey levels].
  void detect(const cv::Mat& derivative, double noise, std::vector<cv::Vec4f>* segments);

 private:
  struct Walk;

  void findRidges(const cv::Mat& derivative, int least);
  void findSeeds(int least);
  void follow(const cv::Mat& derivative, int way, Walk* walk);

  double min_length_ = 0.0;
  cv::Mat magnitude_;  // CV_16SC1: |gx| + |gy|
  cv::Mat upright_;    // CV_16SC1: 1 where |gx| is the larger one
  cv::Mat ridge_;      // CV_8UC1: 1 on an edge that no segment has used
  std::vector<cv::Point> seeds_;
};

}  // namespace slim_init::feature_tracker_lines
