// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/track_images.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "slim_init/evaluation/statistics.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

using feature_tracker_lines::ImageFrontEnd;
using feature_tracker_lines::ImageStatus;

/// Number of observations whose id was there in the image before.
template <typename Observation>
double carried(const std::vector<Observation>& before, const std::vector<Observation>& now) {
  std::unordered_set<FeatureId> ids;
  for (const Observation& observation : before) ids.insert(observation.id);
  return static_cast<double>(std::count_if(
      now.begin(), now.end(), [&ids](const Observation& o) { return ids.count(o.id) > 0; }));
}

void countFeatures(const std::vector<FrameObservation>& frames, TrackingSummary* summary) {
  std::vector<double> points, lines, points_carried, lines_carried;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    points.push_back(static_cast<double>(frames[k].points.size()));
    lines.push_back(static_cast<double>(frames[k].lines.size()));
    if (k == 0) continue;  // it carries nothing on, by definition
    points_carried.push_back(carried(frames[k - 1].points, frames[k].points));
    lines_carried.push_back(carried(frames[k - 1].lines, frames[k].lines));
  }
  summary->points = median(points);
  summary->points_carried = median(points_carried);
  summary->lines = median(lines);
  summary->lines_carried = median(lines_carried);
}

}  // namespace

std::string trackImages(ImageSequence* images,
                        const feature_tracker_lines::CameraParameters& camera,
                        const Calibration& calibration,
                        const feature_tracker_lines::FrontEndOptions& options,
                        const std::function<void(int done, int total)>& progress,
                        std::vector<FrameObservation>* frames, TrackingSummary* summary) {
  frames->clear();
  *summary = TrackingSummary();
  const std::vector<ImuSample>& imu = images->imu;
  ImageFrontEnd front_end(camera, calibration, options);
  std::vector<double> total_ms;
  const int total = static_cast<int>(images->images());
  summary->images = total;
  std::size_t next_imu = 0;
  const auto problem = [summary](const std::string& sentence) {
    if (summary->first_problem.empty()) summary->first_problem = sentence;
  };

  for (std::size_t k = 0; k < images->images(); ++k) {
    const double t = images->image_times[k];
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
      problem(text("image at ", images->stampNs(images->image_times[k]), " ns was refused (",
                   toString(status), "): it has ", image.cols, " x ", image.rows,
                   " pixels, the camera ", camera.width, " x ", camera.height));
      continue;
    }
    total_ms.push_back(front_end.report().total_ms);
    if (front_end.report().rotation_missing) ++summary->images_without_gyro;
    frames->push_back(std::move(frame));
    if (progress) progress(static_cast<int>(k) + 1, total);
  }
  summary->tracked = static_cast<int>(frames->size());
  countFeatures(*frames, summary);
  summary->total_ms_median = median(total_ms);
  if (summary->tracked >= 2) return "";
  return text(images->name, ": ", summary->tracked, " of ", total,
              " images could be tracked (minimum 2): ", summary->outside_imu,
              " lie outside the IMU data, ", summary->unreadable, " cannot be read, ",
              summary->refused, " were refused",
              summary->first_problem.empty() ? "" : "; first: " + summary->first_problem);
}

}  // namespace slim_init::evaluation
