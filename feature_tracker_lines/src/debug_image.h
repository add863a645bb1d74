// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "line_tracker.h"
#include "point_tracker.h"

namespace slim_init::feature_tracker_lines {

/// ImageFrontEnd::debugImage(). `grey` CV_8UC1; `detected` are the detector's segments [px].
cv::Mat drawDebugImage(const cv::Mat& grey, const std::vector<PointTrack>& points,
                       const std::vector<LineTrack>& lines, const std::vector<cv::Vec4f>& detected);

}  // namespace slim_init::feature_tracker_lines
