// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "debug_image.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace slim_init::feature_tracker_lines {
namespace {

// Sub-pixel drawing: OpenCV takes coordinates with binary places.
constexpr int kShift = 4;
const cv::Scalar kDetected(150, 150, 150), kMatched(255, 120, 0);
constexpr int kOldAge = 40;  // images: 2 s at 20 Hz

cv::Point fixedPoint(double x, double y) {
  return {cvRound(x * (1 << kShift)), cvRound(y * (1 << kShift))};
}

// Blue for new over green to red for old.
cv::Scalar ageColour(int age) {
  const double share = std::min(1.0, (age - 1) / static_cast<double>(kOldAge));
  const auto ramp = [share](double middle) {
    return 255.0 * std::clamp(1.5 - 3.0 * std::abs(share - middle), 0.0, 1.0);
  };
  return {ramp(0.0), ramp(0.5), ramp(1.0)};
}

}  // namespace

cv::Mat drawDebugImage(const cv::Mat& grey, const std::vector<PointTrack>& points,
                       const std::vector<LineTrack>& lines,
                       const std::vector<cv::Vec4f>& detected) {
  cv::Mat image;
  cv::cvtColor(grey, image, cv::COLOR_GRAY2BGR);
  for (const cv::Vec4f& s : detected) {
    cv::line(image, fixedPoint(s[0], s[1]), fixedPoint(s[2], s[3]), kDetected, 1, cv::LINE_AA,
             kShift);
  }
  for (const LineTrack& line : lines) {
    // New lines have been drawn as detections.
    if (line.age < 2) continue;
    const Edge& edge = line.edge;
    cv::line(image, fixedPoint(edge.start_pixel.x(), edge.start_pixel.y()),
             fixedPoint(edge.end_pixel.x(), edge.end_pixel.y()), kMatched, 2, cv::LINE_AA, kShift);
  }
  for (const PointTrack& point : points) {
    cv::circle(image, fixedPoint(point.pixel.x, point.pixel.y), 3 << kShift, ageColour(point.age),
               cv::FILLED, cv::LINE_AA, kShift);
  }
  return image;
}

}  // namespace slim_init::feature_tracker_lines
