// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/init_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <utility>

namespace slim_init::node {
namespace {

constexpr double kSameStamp = 1e-4;      // [s], as KeyframeWindow::addLines()
constexpr double kStampRounding = 1e-6;  // [s]
// Frames without IMU and lines without points: nothing waits longer, whoever has fallen silent.
constexpr std::size_t kMostPending = 50;

}  // namespace

std::string InitSessionOptions::validate() const {
  if (attempt_interval_s >= 0.0 && attempt_interval_s <= 60.0) return "";
  std::ostringstream out;
  out << "attempt_interval_s is " << attempt_interval_s << ", must be in [0, 60]";
  return out.str();
}

InitSession::InitSession(std::unique_ptr<IInitializer> initializer,
                         const InitSessionOptions& options)
    : initializer_(std::move(initializer)), options_(options) {}

void InitSession::addImu(const ImuSample& sample) {
  if (initializer_->addImu(sample) == AddStatus::kAdded) t_imu_ = sample.t;
}

void InitSession::addPoints(FrameObservation frame) {
  // Lines older than this frame will not meet theirs any more.
  while (!early_lines_.empty() && early_lines_.front().t < frame.t - kSameStamp) {
    early_lines_.pop_front();
    ++counts_.lines_unmatched;
  }
  PendingFrame pending;
  pending.t = frame.t;
  if (!early_lines_.empty() && std::abs(early_lines_.front().t - frame.t) <= kSameStamp) {
    frame.lines = std::move(early_lines_.front().lines);
    early_lines_.pop_front();
    pending.has_lines = true;
  }
  if (initializer_->addFrame(frame) != AddStatus::kAdded) return;
  ++counts_.frames;
  frames_.push_back(pending);
  if (frames_.size() > kMostPending) {
    frames_.pop_front();
    ++counts_.frames_uncovered;
  }
}

void InitSession::addLines(double t, std::vector<LineObservation> lines) {
  ++counts_.line_messages;
  const auto frame = std::find_if(frames_.begin(), frames_.end(), [t](const PendingFrame& f) {
    return std::abs(f.t - t) <= kSameStamp;
  });
  if (frame != frames_.end()) frame->has_lines = true;
  if (initializer_->addLines(t, lines)) return;
  const bool early = frames_.empty() ? !(t <= t_asked_) : t > frames_.back().t;
  if (!early || (!early_lines_.empty() && t <= early_lines_.back().t)) {
    ++counts_.lines_unmatched;
    return;
  }
  early_lines_.push_back({t, std::move(lines)});
  if (early_lines_.size() > kMostPending) {
    early_lines_.pop_front();
    ++counts_.lines_unmatched;
  }
}

std::optional<Attempt> InitSession::poll() {
  const double td = initializer_->window().calibration().td;
  // The newest frame that is complete; what is older is part of its window.
  std::size_t complete = 0;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    if (!(frames_[i].t + td <= t_imu_)) break;  // NaN before the first sample
    const bool waits_for_lines =
        options_.expect_lines && !frames_[i].has_lines && i + 1 == frames_.size();
    if (!waits_for_lines) complete = i + 1;
  }
  if (complete == 0) return std::nullopt;
  t_newest_covered_ = frames_[complete - 1].t;
  frames_.erase(frames_.begin(), frames_.begin() + static_cast<std::ptrdiff_t>(complete));
  // False before the first attempt.
  const bool too_early =
      t_newest_covered_ < t_asked_ + options_.attempt_interval_s - kStampRounding;
  if (initialized_ || too_early) return std::nullopt;
  return ask(false);
}

Attempt InitSession::request() { return ask(true); }

Attempt InitSession::ask(bool requested) {
  Attempt attempt;
  attempt.number = ++counts_.attempts;
  attempt.t = t_asked_ = t_newest_covered_;
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
  counts_.lines_unmatched += static_cast<std::int64_t>(early_lines_.size());
  initializer_->reset();
  frames_.clear();
  early_lines_.clear();
  t_imu_ = t_asked_ = t_newest_covered_ = kNotComputed;
  initialized_ = false;
}

}  // namespace slim_init::node
