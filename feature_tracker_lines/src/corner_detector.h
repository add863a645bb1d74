// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Shi-Tomasi corners above an absolute threshold, looked for only where points are missing.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace slim_init::feature_tracker_lines {

/// Smaller eigenvalue of the structure tensor (mean over blocks of kCornerBlock pixels of the
/// products of cv::buildOpticalFlowPyramid()'s derivatives, in grey levels per pixel) of the
/// strongest corner in an image of 752 x 480 pixels of pure noise for which measureNoise() gives 1.
/// Grows with the square of the noise.
inline constexpr double kNoiseEigenvalue = 0.75;
inline constexpr int kCornerBlock = 5;  ///< [px], odd
/// Smaller to larger eigenvalue. A strong edge exceeds any threshold that image noise sets, by its
/// stair steps on the pixel grid, and these do not move with the scene.
inline constexpr double kLeastCornerRatio = 0.05;

/// That eigenvalue at a pixel (x, y), which may lie at the edge of the image. `derivative` as in
/// ImagePyramid.
double cornerEigenvalue(const cv::Mat& derivative, int x, int y);

/// Looks for corners cell by cell. Cells that have been looked at longest ago come first, so that a
/// bounded number of cells an image reaches every place in turn and a blank wall does not take all
/// the time.
class CornerDetector {
 public:
  /// `min_distance_px` between two corners; none closer to the edge than `border_px`.
  CornerDetector(cv::Size image_size, double min_distance_px, double border_px);

  /// Appends up to `count` corners, the strongest first, with an eigenvalue of at least
  /// `min_eigenvalue`, from at most `max_cells` cells. `mask` (CV_8UC1) is not zero where a corner
  /// may be; the surroundings of each new one are set to zero in it.
  /// `derivative`: of level 0, CV_16SC2, as in ImagePyramid.
  void detect(const cv::Mat& derivative, double min_eigenvalue, int count, int max_cells,
              cv::Mat* mask, std::vector<cv::Point2f>* corners);

  int cells() const { return static_cast<int>(cells_.size()); }

  void reset();

 private:
  struct Corner {
    float eigenvalue;
    int x, y;
  };
  void sumRows(const cv::Mat& derivative, const cv::Rect& area);
  void computeResponses(const cv::Rect& area);
  void searchCell(const cv::Mat& derivative, const cv::Mat& mask, const cv::Rect& area,
                  float min_eigenvalue, std::vector<Corner>* found);

  struct Cell {
    cv::Rect area;
    std::int64_t last_seen = -1;  // count of detect() calls when last looked at
  };

  int min_distance_ = 0;
  std::vector<Cell> cells_;
  std::int64_t calls_ = 0;
  std::vector<float> products_, sums_, responses_;  // of the cell that is searched
};

}  // namespace slim_init::feature_tracker_lines
