// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "line_detector.h"

#include <algorithm>
#include <opencv2/core/version.hpp>

#if CV_VERSION_MAJOR * 10000 + CV_VERSION_MINOR * 100 + CV_VERSION_REVISION >= 40502
#define SLIM_INIT_HAS_EDGE_DRAWING 1
#include <opencv2/ximgproc/edge_drawing.hpp>
#else
#define SLIM_INIT_HAS_EDGE_DRAWING 0
#include <opencv2/ximgproc/fast_line_detector.hpp>
#endif

namespace slim_init::feature_tracker_lines {
namespace {

#if SLIM_INIT_HAS_EDGE_DRAWING

class EdLines : public LineDetector {
 public:
  explicit EdLines(double min_length_px) : detector_(cv::ximgproc::createEdgeDrawing()) {
    cv::ximgproc::EdgeDrawing::Params params;
    params.MinLineLength = static_cast<int>(min_length_px);
    params.MinPathLength = std::max(8, static_cast<int>(0.75 * min_length_px));
    // EDLines' default. With 0 every local maximum starts an edge, which costs a fifth more time.
    params.AnchorThresholdValue = 8;
    // Validation takes three times as long as all the rest. The refit checks the same: an edge of
    // one sign along the whole segment.
    params.NFAValidation = false;
    detector_->setParams(params);
  }

  const char* name() const override { return "EDLines"; }

  void detect(const cv::Mat& image, std::vector<cv::Vec4f>* segments) override {
    segments->clear();
    try {
      detector_->detectEdges(image);
      detector_->detectLines(*segments);
    } catch (const cv::Exception&) {
      // OpenCV throws for an image without any edge.
      segments->clear();
    }
  }

 private:
  cv::Ptr<cv::ximgproc::EdgeDrawing> detector_;
};

#else

class FastLines : public LineDetector {
 public:
  explicit FastLines(double min_length_px)
      : detector_(cv::ximgproc::createFastLineDetector(static_cast<int>(min_length_px))) {}

  const char* name() const override { return "FLD"; }

  void detect(const cv::Mat& image, std::vector<cv::Vec4f>* segments) override {
    segments->clear();
    try {
      detector_->detect(image, *segments);
    } catch (const cv::Exception&) {
      segments->clear();
    }
  }

 private:
  cv::Ptr<cv::ximgproc::FastLineDetector> detector_;
};

#endif

}  // namespace

std::unique_ptr<LineDetector> makeLineDetector(double min_length_px) {
#if SLIM_INIT_HAS_EDGE_DRAWING
  return std::make_unique<EdLines>(min_length_px);
#else
  return std::make_unique<FastLines>(min_length_px);
#endif
}

}  // namespace slim_init::feature_tracker_lines
