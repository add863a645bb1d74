// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Line segments of an image, by whichever detector this OpenCV has.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace slim_init::feature_tracker_lines {

/// Finds straight edges. Positions are good to a pixel or so: LineTracker refits what it keeps.
class LineDetector {
 public:
  virtual ~LineDetector() = default;

  /// "EDLines" or "FLD".
  virtual const char* name() const = 0;

  /// Segments (x1, y1, x2, y2) of a CV_8UC1 image, in no particular order or sense. None where the
  /// detector fails.
  virtual void detect(const cv::Mat& image, std::vector<cv::Vec4f>* segments) = 0;
};

/// EDLines (Akinlar and Topal 2011) where OpenCV's ximgproc has EdgeDrawing, from 4.5.2 on; else
/// its fast line detector (Lee et al. 2014). Segments shorter than `min_length_px` are left out.
std::unique_ptr<LineDetector> makeLineDetector(double min_length_px);

}  // namespace slim_init::feature_tracker_lines
