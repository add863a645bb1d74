// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/image_pipeline.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "slim_init/text.h"

namespace slim_init::node {
namespace {

using feature_tracker_lines::ImageStatus;

// The messages hold (x, y, 1): a ray has to point forward, and not almost sideways (89.4 deg).
constexpr double kLeastForward = 0.01;
constexpr std::size_t kMostImu = 5000;  // 25 s at 200 Hz, while no image comes

StreamOptions streamOptions(const ImuLimits& limits) {
  StreamOptions options = StreamOptions::liveData(limits);
  options.restart_on_frame_gap = true;
  return options;
}

// Profile `vins` decides by itself which images are published, by the host's rule.
Config withRate(Config config, double publish_rate_hz) {
  int& freq = config.front_end.host.freq;
  freq = publish_rate_hz > 0.0 ? std::max(1, static_cast<int>(std::lround(publish_rate_hz))) : 0;
  return config;
}

bool pointsForward(const Eigen::Vector3d& bearing) { return bearing.z() >= kLeastForward; }

}  // namespace

std::string ImagePipelineOptions::validate() const {
  if (image_queue < 1 || image_queue > 10000) {
    return text("image_queue is ", image_queue, ", must be in [1, 10000]");
  }
  if (!(max_imu_wait_s >= 0.0 && max_imu_wait_s <= 60.0)) {
    return text("max_imu_wait_s is ", max_imu_wait_s, ", must be in [0, 60]");
  }
  if (!(publish_rate_hz >= 0.0 && publish_rate_hz <= 1000.0)) {
    return text("publish_rate_hz is ", publish_rate_hz, ", must be in [0, 1000]");
  }
  return "";
}

ImagePipeline::ImagePipeline(const Config& config, const ImagePipelineOptions& options)
    : config_(withRate(config, options.publish_rate_hz)),
      options_(options),
      check_(streamOptions(config.options.imu)),
      front_end_(config_.camera, config_.calibration, config_.front_end) {
  forgetImages();
}

void ImagePipeline::forgetImages() {
  front_end_.reset();
  images_.clear();
  t_fed_imu_ = t_image_ = t_next_publish_ = kNotComputed;
  previous_ = FrameObservation();
  previous_.t = kNotComputed;
}

void ImagePipeline::forgetImu() {
  imu_.clear();
  t_first_imu_ = t_imu_ = kNotComputed;
}

AddStatus ImagePipeline::addImu(const ImuSample& sample) {
  const AddStatus status = check_.checkImu(sample);
  if (!isAdded(status)) return status;
  if (status == AddStatus::kRestarted) {
    forgetImages();
    forgetImu();
  }
  if (std::isnan(t_first_imu_)) t_first_imu_ = sample.t;
  t_imu_ = sample.t;
  imu_.push_back(sample);
  if (imu_.size() > kMostImu) imu_.pop_front();
  return status;
}

AddStatus ImagePipeline::addImage(double t, const cv::Mat& image) {
  const AddStatus status = check_.checkFrame(config_.calibration.imuTime(t));
  if (!isAdded(status)) return status;
  if (status == AddStatus::kRestarted) {
    // A gap in the images, in which the IMU has gone on, is no other time.
    const bool is_gap =
        t > t_image_ && std::abs(config_.calibration.imuTime(t) - t_imu_) <= StreamCheck::kJump;
    forgetImages();
    if (!is_gap) forgetImu();
  }
  ++counts_.images;
  t_image_ = t;
  images_.push_back({t, image});
  if (static_cast<int>(images_.size()) > options_.image_queue) {
    images_.pop_front();
    ++counts_.images_overrun;
  }
  return status;
}

std::optional<TrackedFrame> ImagePipeline::track(bool* worked) {
  *worked = false;
  const Calibration& calibration = config_.calibration;
  // Known to be older than any sample that will come.
  while (!images_.empty() && calibration.imuTime(images_.front().t) < t_first_imu_) {
    images_.pop_front();
    ++counts_.images_before_imu;
  }
  if (images_.empty()) return std::nullopt;
  const double t_image = calibration.imuTime(images_.front().t);
  const bool covered = t_image <= t_imu_;  // false without IMU
  // A queue of one would never wait for the IMU.
  const bool may_wait = t_image_ - images_.front().t < options_.max_imu_wait_s &&
                        static_cast<int>(images_.size()) < std::max(2, options_.image_queue);
  if (!covered && config_.front_end.use_gyro && may_wait) return std::nullopt;

  *worked = true;
  const PendingImage image = std::move(images_.front());
  images_.pop_front();
  while (!imu_.empty() && !(t_fed_imu_ >= t_image)) {
    front_end_.addImu(imu_.front());
    t_fed_imu_ = imu_.front().t;
    imu_.pop_front();
  }
  TrackedFrame tracked;
  if (front_end_.addImage(image.t, image.image, &tracked.frame) != ImageStatus::kTracked) {
    ++counts_.images_refused;
    return std::nullopt;
  }
  ++counts_.images_tracked;
  if (!covered) ++counts_.images_without_imu;
  keepForward(&tracked.frame);
  tracked.previous = std::exchange(previous_, tracked.frame);
  if (!publishNow(image.t)) return std::nullopt;
  if (config_.estimate_td) keepMoving(&tracked);
  ++counts_.frames_published;
  return tracked;
}

// The first image after a start has no velocities; the host's own tracker leaves it out as well.
bool ImagePipeline::publishNow(double t) {
  const double interval = options_.publish_rate_hz > 0.0 ? 1.0 / options_.publish_rate_hz : 0.0;
  if (std::isnan(t_next_publish_)) {
    t_next_publish_ = t + interval;
    return false;
  }
  if (config_.front_end.profile == feature_tracker_lines::TrackerProfile::kVins) {
    return front_end_.report().publishable;
  }
  // Stamps jitter about their grid: a quarter of an interval early is in time.
  if (t < t_next_publish_ - 0.25 * interval) return false;
  // The grid goes on from where it was; after a pause it starts anew.
  t_next_publish_ = std::max(t_next_publish_ + interval, t + 0.5 * interval);
  return true;
}

// A host that estimates td moves every point by its velocity times td; a point that is seen for the
// first time has none, and zero pulls the estimate to zero. The host's own tracker leaves it out.
void ImagePipeline::keepMoving(TrackedFrame* tracked) {
  std::unordered_set<FeatureId> known;
  for (const PointObservation& point : tracked->previous.points) known.insert(point.id);
  auto& points = tracked->frame.points;
  points.erase(
      std::remove_if(points.begin(), points.end(),
                     [&known](const PointObservation& p) { return known.count(p.id) == 0; }),
      points.end());
}

void ImagePipeline::keepForward(FrameObservation* frame) {
  const std::size_t before = frame->points.size() + frame->lines.size();
  auto& points = frame->points;
  points.erase(std::remove_if(points.begin(), points.end(),
                              [](const PointObservation& p) { return !pointsForward(p.bearing); }),
               points.end());
  auto& lines = frame->lines;
  lines.erase(std::remove_if(lines.begin(), lines.end(),
                             [](const LineObservation& l) {
                               return !pointsForward(l.start_bearing) ||
                                      !pointsForward(l.end_bearing);
                             }),
              lines.end());
  counts_.observations_sideways += static_cast<std::int64_t>(before - points.size() - lines.size());
}

}  // namespace slim_init::node
