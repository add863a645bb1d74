// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/keyframe_window.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "data/clean_frame.h"

namespace slim_init {
namespace {

// Frames at exactly the interval count; a stamp in seconds since 1970 has 0.2 us of rounding [s].
constexpr double kStampRounding = 1e-6;
// Two stamps of one image differ by rounding at most, those of two images by far more [s].
constexpr double kSameStamp = 1e-4;

}  // namespace

KeyframeWindow::KeyframeWindow(const Calibration& calibration, const WindowOptions& options)
    : calibration_(calibration), options_(options) {}

AddStatus KeyframeWindow::addImu(const ImuSample& sample) {
  if (!std::isfinite(sample.t) || !sample.gyro.allFinite() || !sample.accel.allFinite()) {
    ++counts_.imu_not_finite;
    return AddStatus::kNotFinite;
  }
  if (!imu_.empty() && sample.t <= imu_.back().t) {
    ++counts_.imu_out_of_order;
    return AddStatus::kOutOfOrder;
  }
  imu_.push_back(sample);
  ++counts_.imu_added;
  trim();
  return AddStatus::kAdded;
}

AddStatus KeyframeWindow::addFrame(const FrameObservation& frame) {
  const double t_imu = frame.t + calibration_.td;
  if (!std::isfinite(t_imu)) {
    ++counts_.frames_not_finite;
    return AddStatus::kNotFinite;
  }
  if (!frames_.empty() && t_imu <= frames_.back().t) {
    ++counts_.frames_out_of_order;
    return AddStatus::kOutOfOrder;
  }
  frames_.push_back(frame);
  frames_.back().t = t_imu;
  cleanFrame(frames_.back(), counts_);
  ++counts_.frames_added;
  trim();
  return AddStatus::kAdded;
}

bool KeyframeWindow::addLines(double t, const std::vector<LineObservation>& lines) {
  const double t_imu = t + calibration_.td;
  for (auto frame = frames_.rbegin(); frame != frames_.rend(); ++frame) {
    if (std::abs(frame->t - t_imu) > kSameStamp) continue;
    if (!frame->lines.empty()) return false;
    frame->lines = lines;
    cleanFrame(*frame, counts_);
    return true;
  }
  return false;
}

WindowCut KeyframeWindow::cut() const {
  WindowCut result;
  std::ostringstream out;

  // The newest frame that the IMU covers, then backwards.
  int newest = static_cast<int>(frames_.size()) - 1;
  while (newest >= 0 && (imu_.empty() || frames_[newest].t > imu_.back().t)) --newest;

  // The last gap between IMU samples before the newest frame bounds the window from below.
  double t_imu_start = std::numeric_limits<double>::infinity();
  if (newest >= 0) {
    // The first sample at or after the frame closes the window; it exists, the IMU covers the
    // frame.
    auto sample = std::lower_bound(imu_.begin(), imu_.end(), frames_[newest].t,
                                   [](const ImuSample& s, double t) { return s.t < t; });
    while (sample != imu_.begin() && sample->t - std::prev(sample)->t <= options_.max_imu_gap_s) {
      --sample;
    }
    t_imu_start = sample->t;
  }

  std::vector<int> chosen;
  std::string reason = "no frame is covered by the IMU yet";
  for (int i = newest; i >= 0 && static_cast<int>(chosen.size()) < options_.keyframes; --i) {
    reason = "more frames are needed";
    if (i < newest && frames_[i + 1].t - frames_[i].t > options_.max_frame_gap_s) {
      out << "a gap of " << frames_[i + 1].t - frames_[i].t << " s between frames (bound "
          << options_.max_frame_gap_s << " s) starts the window anew";
      reason = out.str();
      break;
    }
    if (frames_[i].t < t_imu_start) {
      if (t_imu_start > frames_[newest].t) {
        out << "the newest frame lies in a gap of the IMU data above " << options_.max_imu_gap_s
            << " s";
      } else {
        out << "IMU data start or have a gap above " << options_.max_imu_gap_s << " s "
            << frames_[newest].t - t_imu_start << " s before the newest frame";
      }
      reason = out.str();
      break;
    }
    if (chosen.empty() ||
        frames_[chosen.back()].t - frames_[i].t >= options_.min_interval_s - kStampRounding) {
      chosen.push_back(i);
    }
  }

  if (static_cast<int>(chosen.size()) < options_.min_keyframes) {
    std::ostringstream message;
    message << "window holds " << chosen.size() << " keyframes, needs " << options_.min_keyframes
            << ": " << reason;
    result.message = message.str();
    return result;
  }

  std::vector<FrameObservation> keyframes;
  keyframes.reserve(chosen.size());
  for (auto i = chosen.rbegin(); i != chosen.rend(); ++i) keyframes.push_back(frames_[*i]);

  // Samples from the last one at or before the first keyframe to the first at or after the last.
  const auto time_before = [](double t, const ImuSample& s) { return t < s.t; };
  const auto sample_before = [](const ImuSample& s, double t) { return s.t < t; };
  auto first = std::upper_bound(imu_.begin(), imu_.end(), keyframes.front().t, time_before);
  if (first != imu_.begin()) --first;
  auto last = std::lower_bound(imu_.begin(), imu_.end(), keyframes.back().t, sample_before);
  if (last != imu_.end()) ++last;

  std::string error;
  result.window =
      InitWindow::create(calibration_, keyframes, std::vector<ImuSample>(first, last), &error);
  if (result.window == nullptr) {
    result.status = InitStatus::kInvalidInput;
    result.message = error;
    return result;
  }
  result.status = InitStatus::kSuccess;
  std::ostringstream message;
  message << "window of " << keyframes.size() << " keyframes over "
          << keyframes.back().t - keyframes.front().t << " s";
  result.message = message.str();
  return result;
}

void KeyframeWindow::reset() {
  imu_.clear();
  frames_.clear();
  counts_ = WindowCounts();
}

void KeyframeWindow::trim() {
  // Each stream is bounded by itself, so that neither a silent camera nor a silent IMU makes the
  // other grow without limit.
  while (imu_.size() > 2 && imu_[1].t < imu_.back().t - options_.buffer_s) imu_.pop_front();
  while (frames_.size() > 1 && frames_.front().t < frames_.back().t - options_.buffer_s) {
    frames_.pop_front();
  }
}

}  // namespace slim_init
