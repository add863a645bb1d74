// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "feature_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "debug_image.h"
#include "stopwatch.h"
#include "vins_constants.h"

namespace slim_init::feature_tracker_lines {
namespace {

// Distance of points in a halved image [px], at least: closer ones share most of their patches.
constexpr double kLeastDistancePx = 10.0;

// A dark image is tracked with its grey levels multiplied by 2, 4 or 8: all its contrast lies in a
// few levels, and the fixed-point arithmetic of detection and tracking rounds most of it away. What
// counts is the level that one pixel in a hundred exceeds. The factor is kept while that level
// stays between these two, since a change costs a pyramid.
constexpr int kMaxGain = 8;
constexpr int kDarkLevel = 60, kBrightLevel = 240;
constexpr int kWantedLevel = 160;  // after a change at most

// Grey level that one of a hundred pixels exceeds; every fourth row and column counts.
int brightLevel(const cv::Mat& grey) {
  std::array<int, 256> histogram{};
  int count = 0;
  for (int y = 0; y < grey.rows; y += 4) {
    const uchar* row = grey.ptr<uchar>(y);
    for (int x = 0; x < grey.cols; x += 4, ++count) ++histogram[row[x]];
  }
  int level = 255;
  for (int above = histogram[255]; level > 0 && 100 * above <= count;) {
    above += histogram[static_cast<std::size_t>(--level)];
  }
  return level;
}

int gainFor(const cv::Mat& grey, int present) {
  const int level = brightLevel(grey);
  const int seen = level * present;
  // As it came until it is dark, and brightened until it is bright.
  if (present == 1 ? seen >= kDarkLevel : seen >= kDarkLevel && seen <= kBrightLevel) {
    return present;
  }
  int gain = 1;
  while (gain < kMaxGain && 2 * gain * level <= kWantedLevel) gain *= 2;
  return gain;
}

// VINS-Mono works on the image as it is.
int halvingsOf(const CameraParameters& camera, TrackerProfile profile) {
  return profile == TrackerProfile::kVins ? 0 : halvingsFor({camera.width, camera.height});
}

// The camera of the halved image, whose pixel (x, y) lies at (2 x, 2 y).
CameraParameters halved(CameraParameters camera, int halvings) {
  for (int i = 0; i < halvings; ++i) {
    camera.width = (camera.width + 1) / 2;
    camera.height = (camera.height + 1) / 2;
    for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *value *= 0.5;
  }
  return camera;
}

// The options for that image: the distance between points is one in the camera's image.
FrontEndOptions halved(FrontEndOptions options, const CameraParameters& camera, int halvings) {
  if (halvings == 0) return options;
  double& distance_px = options.points.min_distance_px;
  distance_px =
      std::max(std::ldexp(distance_px, -halvings), std::min(distance_px, kLeastDistancePx));
  if (!options.mask.empty()) {
    cv::resize(options.mask, options.mask, cv::Size(camera.width, camera.height), 0.0, 0.0,
               cv::INTER_NEAREST);
  }
  return options;
}

}  // namespace

FeatureTracker::FeatureTracker(const CameraParameters& camera, const FrontEndOptions& options)
    : halvings_(halvingsOf(camera, options.profile)),
      options_(halved(options, halved(camera, halvings_), halvings_)),
      points_(halved(camera, halvings_), options_),
      lines_(halved(camera, halvings_), options_) {}

void FeatureTracker::reset() {
  points_.reset();
  lines_.reset();
  before_ = ImagePyramid();
  now_ = ImagePyramid();
  gain_ = 1;
}

void FeatureTracker::track(double t, const cv::Mat& grey, const RotationPrior& prior,
                           FrameObservation* frame, ImageReport* report) {
  Stopwatch watch;
  std::swap(before_, now_);
  prepare(grey);
  report->image_noise = now_.noise;
  report->stages.push_back({"prepare", watch.lap()});

  trackFeatures(t, prior, report);
  writeObservations(frame);
}

// Lines move as the points do that were followed, beyond the rotation that these were found with.
void FeatureTracker::trackFeatures(double t, const RotationPrior& given, ImageReport* report) {
  Stopwatch watch;
  RotationPrior prior = given;
  points_.follow(t, before_, now_, &prior, report);
  report->stages.push_back({"points", watch.lap()});
  points_.refill(now_, report);
  report->stages.push_back({"new_points", watch.lap()});
  if (!options_.lines.enabled) return;
  std::vector<LineSegment> segments = lines_.detect(now_, given);
  report->stages.push_back({"segments", watch.lap()});
  lines_.track(before_, now_, prior, std::move(segments), points_.motion(prior), report);
  report->stages.push_back({"lines", watch.lap()});
}

// Builds the pyramid of the image, brightened where it is dark and the host's `equalize` allows it.
// Both images of a step have the same factor: KLT compares grey levels.
void FeatureTracker::brighten(const cv::Mat& grey) {
  const int gain = options_.host.equalize ? gainFor(grey, gain_) : 1;
  if (gain != gain_ && !before_.empty()) build(raw_, gain, &before_);
  gain_ = gain;
  if (options_.host.equalize) grey.copyTo(raw_);
  build(grey, gain, &now_);
}

void FeatureTracker::build(const cv::Mat& grey, int gain, ImagePyramid* out) {
  if (gain > 1) grey.convertTo(equalized_, CV_8U, gain);
  buildImagePyramid(gain > 1 ? equalized_ : grey, options_.points.window_px,
                    std::max(options_.points.levels, 1), halvings_, out);
}

// Builds the pyramid, of the equalized image where VINS-Mono equalizes.
void FeatureTracker::prepare(const cv::Mat& grey) {
  if (options_.profile != TrackerProfile::kVins) {
    brighten(grey);
    return;
  }
  if (options_.host.equalize) {
    cv::createCLAHE(vins::kClaheLimit, cv::Size(vins::kClaheTiles, vins::kClaheTiles))
        ->apply(grey, equalized_);
  }
  buildImagePyramid(options_.host.equalize ? equalized_ : grey, vins::kWindowPx, vins::kLevels,
                    halvings_, &now_);
}

void FeatureTracker::writeObservations(FrameObservation* frame) const {
  const double scale = std::ldexp(1.0, halvings_);
  frame->points.clear();
  for (const PointTrack& track : points_.tracks()) {
    PointObservation point;
    point.id = track.id;
    point.bearing = track.bearing;
    point.pixel = scale * Eigen::Vector2d(track.pixel.x, track.pixel.y);
    frame->points.push_back(point);
  }
  frame->lines.clear();
  const RowCamera& lens = lines_.lens();
  for (const LineTrack& track : lines_.tracks()) {
    LineObservation line;
    line.id = track.id;
    line.start_bearing = lens.atOwnRow(track.edge.start, track.edge.start_pixel);
    line.end_bearing = lens.atOwnRow(track.edge.end, track.edge.end_pixel);
    line.start_pixel = scale * track.edge.start_pixel;
    line.end_pixel = scale * track.edge.end_pixel;
    line.length_px = scale * track.edge.length_px;
    line.detection_confidence = track.confidence;
    line.match_quality = track.match_quality;
    frame->lines.push_back(line);
  }
}

cv::Mat FeatureTracker::debugImage() const {
  if (now_.empty()) return {};
  return drawDebugImage(now_.level(0), points_.tracks(), lines_.tracks(), lines_.detected());
}

}  // namespace slim_init::feature_tracker_lines
