// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/init_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "slim_init/keyframe_window.h"
#include "slim_init/text.h"
#include "slim_init/types.h"

namespace slim_init::node {
namespace {

// Frames that wait for IMU samples: the queue is bounded when the IMU falls silent.
constexpr std::size_t kMostPending = 50;

}  // namespace

std::string InitSessionOptions::validate() const {
  if (attempt_interval_s >= 0.0 && attempt_interval_s <= 60.0) return "";
  return text("attempt_interval_s is ", attempt_interval_s, ", must be in [0, 60]");
}

InitSession::InitSession(std::unique_ptr<IInitializer> initializer,
                         const InitSessionOptions& options)
    : initializer_(std::move(initializer)), options_(options), screen_(options.imu) {}

AddStatus InitSession::addImu(const ImuSample& sample) {
  const AddStatus status = screen_.pass(sample, [this](const ImuSample& one) {
    const AddStatus of_one = initializer_->addImu(one);
    if (of_one == AddStatus::kRestarted) forget();
    return of_one;
  });
  if (isAdded(status)) t_imu_ = sample.t;
  return status;
}

AddStatus InitSession::addPoints(FrameObservation frame) {
  PendingFrame pending;
  pending.t = frame.t;
  findRows(&frame);
  const std::int64_t merged_before = initializer_->info().counts.lines[AddStatus::kAdded];
  const AddStatus status = initializer_->addFrame(std::move(frame));
  if (status == AddStatus::kRestarted) forget();
  if (!isAdded(status)) return status;
  // Its lines were there first.
  pending.has_lines = initializer_->info().counts.lines[AddStatus::kAdded] > merged_before;
  frames_.push_back(pending);
  if (frames_.size() > kMostPending) {
    frames_.pop_front();
    ++counts_.frames_uncovered;
  }
  return status;
}

AddStatus InitSession::addLines(double t, std::vector<LineObservation> lines) {
  const auto frame = std::find_if(frames_.begin(), frames_.end(), [t](const PendingFrame& f) {
    return std::abs(f.t - t) <= KeyframeWindow::kSameStamp;
  });
  if (frame != frames_.end()) frame->has_lines = true;
  FrameObservation observed;
  observed.lines = std::move(lines);
  findRows(&observed);
  return initializer_->addLines(t, std::move(observed.lines));
}

void InitSession::findRows(FrameObservation* frame) const {
  if (options_.image_height > 0) setRows(options_.image_height, frame);
}

std::optional<Attempt> InitSession::poll() {
  const Calibration calibration = initializer_->info().calibration;
  // The newest frame that is complete; what is older is part of its window.
  std::size_t complete = 0;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    if (!(calibration.imuTime(frames_[i].t) <= t_imu_)) break;  // NaN before the first sample
    const bool waits_for_lines =
        options_.expect_lines && !frames_[i].has_lines && i + 1 == frames_.size();
    if (!waits_for_lines) complete = i + 1;
  }
  if (complete == 0) return std::nullopt;
  t_newest_covered_ = frames_[complete - 1].t;
  frames_.erase(frames_.begin(), frames_.begin() + static_cast<std::ptrdiff_t>(complete));
  // False before the first attempt.
  const bool too_early =
      t_newest_covered_ < t_attempt_ + options_.attempt_interval_s - kStampRounding;
  if (initialized_ || too_early) return std::nullopt;
  return attempt(false);
}

Attempt InitSession::initialize() { return attempt(true); }

Attempt InitSession::attempt(bool requested) {
  Attempt attempt;
  attempt.number = ++counts_.attempts;
  attempt.t = t_attempt_ = t_newest_covered_;
  attempt.requested = requested;
  const auto start = std::chrono::steady_clock::now();
  attempt.result = initializer_->initialize();
  attempt.total_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  initialized_ = attempt.result.success();
  if (initialized_) ++counts_.successes;
  return attempt;
}

void InitSession::restart() {
  ++counts_.restarts;
  before_restart_ = streamCounts();
  before_restart_.lines[AddStatus::kUnmatched] +=
      std::exchange(before_restart_.lines[AddStatus::kWaiting], 0);
  initializer_->reset();
  screen_ = host_health::ImuScreen(options_.imu);
  forget();
}

void InitSession::forget() {
  frames_.clear();
  screen_.reset();
  t_imu_ = t_attempt_ = t_newest_covered_ = kNotComputed;
  initialized_ = false;
}

StreamCounts InitSession::streamCounts() const {
  StreamCounts counts = before_restart_;
  counts.imu[AddStatus::kGlitch] += screen_.discarded();
  return counts += initializer_->info().counts;
}

}  // namespace slim_init::node
