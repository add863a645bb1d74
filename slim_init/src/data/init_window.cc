// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/init_window.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "data/clean_frame.h"
#include "geometry/so3.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

// Groups observations into tracks with at least two of them, by id, ascending in keyframe.
template <typename Observation>
void buildTracks(std::vector<Observation>& all, std::vector<Track>& tracks,
                 std::vector<Observation>& observations) {
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.id < b.id; });
  observations.reserve(all.size());
  for (std::size_t begin = 0; begin < all.size();) {
    std::size_t end = begin + 1;
    while (end < all.size() && all[end].id == all[begin].id) ++end;
    if (end - begin >= 2) {
      Track track;
      track.id = all[begin].id;
      track.begin = static_cast<int>(observations.size());
      observations.insert(observations.end(), all.begin() + begin, all.begin() + end);
      track.end = static_cast<int>(observations.size());
      tracks.push_back(track);
    }
    begin = end;
  }
}

// Empty, or a message naming the first of `size` times that is not finite or not after the one
// before.
template <typename Time>
std::string checkAscending(const char* what, std::size_t size, const Time& time) {
  for (std::size_t i = 0; i < size; ++i) {
    if (!std::isfinite(time(i))) return text(what, i, " is not finite");
    if (i == 0 || time(i) > time(i - 1)) continue;
    return text(what, i, " is ", time(i) - time(i - 1),
                " s after the one before, must be positive");
  }
  return "";
}

// Empty, or a message naming the first speed that a stream would not take.
std::string checkSpeeds(const std::vector<SpeedSample>& speeds, const SpeedSensor& sensor) {
  StreamCheck check;
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    if (isAdded(check.checkSpeed(speeds[i], sensor))) continue;
    return "speed " + std::to_string(i) +
           " is not finite, too fast, without positive definite covariance, not after the one "
           "before, or of a sensor without extrinsics";
  }
  return "";
}

std::shared_ptr<const InitWindow> fail(std::string* error, const std::string& message) {
  if (error != nullptr) *error = message;
  return nullptr;
}

}  // namespace

std::shared_ptr<const InitWindow> InitWindow::create(const Calibration& calibration,
                                                     const std::vector<FrameObservation>& keyframes,
                                                     std::vector<ImuSample> imu, std::string* error,
                                                     std::vector<SpeedSample> speeds) {
  std::vector<FrameObservation> clean = keyframes;
  std::vector<const FrameObservation*> pointers;
  std::vector<double> times;
  StreamCounts discarded;
  for (FrameObservation& frame : clean) {
    cleanFrame(frame, discarded);
    pointers.push_back(&frame);
    times.push_back(frame.t);
  }
  return fromCleanFrames(calibration, pointers, std::move(times), std::move(imu), error,
                         std::move(speeds));
}

std::shared_ptr<const InitWindow> InitWindow::fromCleanFrames(
    const Calibration& calibration, const std::vector<const FrameObservation*>& keyframes,
    std::vector<double> times, std::vector<ImuSample> imu, std::string* error,
    std::vector<SpeedSample> speeds) {
  if (const std::string message = calibration.validate(); !message.empty()) {
    return fail(error, "calibration: " + message);
  }
  if (keyframes.size() < 2) {
    return fail(error, text("window has ", keyframes.size(), " keyframes (minimum 2)"));
  }
  std::string order = checkAscending("time of keyframe ", keyframes.size(),
                                     [&](std::size_t k) { return times[k]; });
  if (order.empty()) {
    order = checkAscending("IMU sample ", imu.size(), [&](std::size_t i) {
      return imu[i].gyro.allFinite() && imu[i].accel.allFinite() ? imu[i].t : kNotComputed;
    });
  }
  if (!order.empty()) return fail(error, order);
  if (const std::string message = checkSpeeds(speeds, calibration.speed_sensor); !message.empty()) {
    return fail(error, message);
  }
  if (imu.size() < 2 || imu.front().t > times.front() || imu.back().t < times.back()) {
    std::string message = text("IMU data do not cover the window: ", imu.size(), " samples");
    if (!imu.empty()) {
      message += text(" from ", imu.front().t - times.front(), " s after its start to ",
                      times.back() - imu.back().t, " s before its end");
    }
    return fail(error, message);
  }

  const auto common = std::make_shared<Common>();
  common->calibration = calibration;
  // Its digits may leave it off a rotation by as much as validate() accepts.
  common->calibration.R_b_c = nearestRotation(calibration.R_b_c);
  common->imu = std::move(imu);
  common->speeds = std::move(speeds);
  common->times = std::move(times);
  common->keyframe_lines.resize(keyframes.size());
  std::vector<WindowPoint> points;
  std::vector<WindowLine> lines;
  for (int k = 0; k < static_cast<int>(keyframes.size()); ++k) {
    for (const PointObservation& point : keyframes[k]->points) points.push_back({point, k});
    for (const LineObservation& line : keyframes[k]->lines) {
      lines.push_back({line, k, line.start_bearing.cross(line.end_bearing).normalized()});
      common->keyframe_lines[k].push_back(lines.back());
    }
  }
  const std::shared_ptr<InitWindow> window(new InitWindow());
  buildTracks(points, window->point_tracks_, window->point_observations_);
  buildTracks(lines, common->line_tracks, common->line_observations);
  window->common_ = common;
  return window;
}

}  // namespace slim_init
