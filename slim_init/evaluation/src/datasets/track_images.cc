// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/track_images.h"

#include <unordered_set>
#include <utility>

#include "slim_init/evaluation/statistics.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

using feature_tracker_lines::ImageFrontEnd;
using feature_tracker_lines::ImageReport;
using feature_tracker_lines::ImageStatus;

/// Collects one number per image.
class SummaryCollector {
 public:
  void add(const FrameObservation& frame, const ImageReport& report) {
    points_.push_back(static_cast<double>(frame.points.size()));
    lines_.push_back(static_cast<double>(frame.lines.size()));
    const double carried_points = carried(frame.points, &point_ids_);
    const double carried_lines = carried(frame.lines, &line_ids_);
    // The first image carries nothing on, by definition.
    if (points_.size() > 1) {
      points_carried_.push_back(carried_points);
      lines_carried_.push_back(carried_lines);
    }
    total_ms_.push_back(report.total_ms);
    if (report.rotation_missing) ++without_gyro_;
  }

  void finish(TrackingSummary* summary) const {
    summary->points = median(points_);
    summary->points_carried = median(points_carried_);
    summary->lines = median(lines_);
    summary->lines_carried = median(lines_carried_);
    summary->images_without_gyro = without_gyro_;
    summary->total_ms_median = median(total_ms_);
  }

 private:
  /// Number of observations whose id was there in the image before.
  template <typename Observation>
  static double carried(const std::vector<Observation>& observations,
                        std::unordered_set<FeatureId>* before) {
    std::unordered_set<FeatureId> ids;
    int count = 0;
    for (const Observation& observation : observations) {
      if (before->count(observation.id) > 0) ++count;
      ids.insert(observation.id);
    }
    *before = std::move(ids);
    return count;
  }

  std::vector<double> points_, lines_, points_carried_, lines_carried_, total_ms_;
  std::unordered_set<FeatureId> point_ids_, line_ids_;
  int without_gyro_ = 0;
};

}  // namespace

std::string trackImages(ImageSequence* images,
                        const feature_tracker_lines::CameraParameters& camera,
                        const Calibration& calibration,
                        const feature_tracker_lines::FrontEndOptions& options,
                        const std::function<void(int done, int total)>& progress,
                        std::vector<FrameObservation>* frames, TrackingSummary* summary) {
  frames->clear();
  *summary = TrackingSummary();
  const std::vector<ImuSample>& imu = images->imu();
  ImageFrontEnd front_end(camera, calibration, options);
  SummaryCollector collector;
  const int total = static_cast<int>(images->images());
  summary->images = total;
  std::size_t next_imu = 0;
  const auto problem = [summary](const std::string& sentence) {
    if (summary->first_problem.empty()) summary->first_problem = sentence;
  };

  for (std::size_t k = 0; k < images->images(); ++k) {
    const double t = images->imageTime(k);
    const double t_imu = t + calibration.td;
    if (imu.empty() || t_imu < imu.front().t || t_imu > imu.back().t) {
      ++summary->outside_imu;
      continue;
    }
    std::string sentence;
    const cv::Mat image = images->image(k, &sentence);
    if (image.empty()) {
      ++summary->unreadable;
      problem(sentence);
      continue;
    }
    // Up to the first sample at or after the image, which then is covered.
    while (next_imu < imu.size() && (next_imu == 0 || imu[next_imu - 1].t < t_imu)) {
      front_end.addImu(imu[next_imu++]);
    }
    FrameObservation frame;
    const ImageStatus status = front_end.addImage(t, image, &frame);
    if (status != ImageStatus::kTracked) {
      ++summary->refused;
      problem(text("image at ", images->imageStampNs(k), " ns was refused (", toString(status),
                   "): it has ", image.cols, " x ", image.rows, " pixels, the camera ",
                   camera.width, " x ", camera.height));
      continue;
    }
    collector.add(frame, front_end.report());
    frames->push_back(std::move(frame));
    if (progress) progress(static_cast<int>(k) + 1, total);
  }
  summary->tracked = static_cast<int>(frames->size());
  collector.finish(summary);
  if (summary->tracked >= 2) return "";
  return text(images->name(), ": ", summary->tracked, " of ", total,
              " images could be tracked (minimum 2): ", summary->outside_imu,
              " lie outside the IMU data, ", summary->unreadable, " cannot be read, ",
              summary->refused, " were refused",
              summary->first_problem.empty() ? "" : "; first: " + summary->first_problem);
}

}  // namespace slim_init::evaluation
