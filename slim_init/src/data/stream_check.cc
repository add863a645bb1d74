// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/stream_check.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/dense.h"
#include "slim_init/text.h"

namespace slim_init {

const char* toString(AddStatus status) {
  switch (status) {
    case AddStatus::kAdded: return "added";
    case AddStatus::kRestarted: return "restarted";
    case AddStatus::kNotFinite: return "not finite";
    case AddStatus::kGlitch: return "glitch";
    case AddStatus::kOutOfOrder: return "late";
    case AddStatus::kStray: return "stray stamp";
    case AddStatus::kBeforeJump: return "before a time jump";
    case AddStatus::kWaiting: return "waiting";
    case AddStatus::kUnmatched: return "without frame";
    case AddStatus::kNotSupported: return "not supported";
    case AddStatus::kNoCovariance: return "covariance not positive definite";
    case AddStatus::kNotCalibrated: return "sensor not calibrated";
  }
  return "unknown";
}

std::int64_t MessageCounts::added() const {
  return (*this)[AddStatus::kAdded] + (*this)[AddStatus::kRestarted];
}

MessageCounts& MessageCounts::operator+=(const MessageCounts& other) {
  for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
  return *this;
}

AddStatus MessageCounts::count(AddStatus status) {
  ++(*this)[status];
  return status;
}

StreamCounts& StreamCounts::operator+=(const StreamCounts& other) {
  imu += other.imu;
  frames += other.frames;
  speeds += other.speeds;
  lines += other.lines;
  observations_not_finite += other.observations_not_finite;
  observations_duplicate_id += other.observations_duplicate_id;
  lines_degenerate += other.lines_degenerate;
  return *this;
}

std::string droppedSince(const StreamCounts& before, const StreamCounts& now) {
  std::string list;
  const auto add = [&list](const char* what, const char* why, std::int64_t count) {
    if (count > 0) list += text(list.empty() ? "" : ", ", count, ' ', what, " (", why, ')');
  };
  const std::pair<const char*, MessageCounts StreamCounts::*> streams[] = {
      {"IMU samples", &StreamCounts::imu},
      {"frames", &StreamCounts::frames},
      {"messages of lines", &StreamCounts::lines},
      {"velocities", &StreamCounts::speeds}};
  for (const auto& [what, stream] : streams) {
    for (int i = 0; i < MessageCounts::kStatuses; ++i) {
      const auto status = static_cast<AddStatus>(i);
      if (!isDropped(status)) continue;
      add(what, toString(status), (now.*stream)[status] - (before.*stream)[status]);
    }
  }
  add("observations", "not finite", now.observations_not_finite - before.observations_not_finite);
  add("observations", "id used twice",
      now.observations_duplicate_id - before.observations_duplicate_id);
  add("lines", "without length", now.lines_degenerate - before.lines_degenerate);
  return list;
}

StreamOptions StreamOptions::liveData(const ImuLimits& imu) {
  StreamOptions options;
  options.imu = imu;
  options.live = true;
  return options;
}

AddStatus StreamCheck::checkImu(const ImuSample& sample) {
  AddStatus status = AddStatus::kNotFinite;
  if (options_.imu.exceededBy(sample)) {
    status = AddStatus::kGlitch;
  } else if (std::isfinite(sample.t) && sample.gyro.allFinite() && sample.accel.allFinite()) {
    status = checkTime(sample.t, false, &imu_);
  }
  return counts_.imu.count(status);
}

AddStatus StreamCheck::checkFrame(double t) {
  AddStatus status = AddStatus::kNotFinite;
  if (std::isfinite(t)) status = checkTime(t, options_.restart_on_frame_gap, &frames_);
  return counts_.frames.count(status);
}

AddStatus StreamCheck::checkSpeed(const SpeedSample& sample, const SpeedSensor& sensor) {
  const int rows = sample.forward_only ? 1 : 3;
  const auto covariance = sample.covariance.topLeftCorner(rows, rows);
  const auto velocity = sample.velocity.head(rows);
  const auto counted = [this](AddStatus status) { return counts_.speeds.count(status); };
  if (!sensor.calibrated) return counted(AddStatus::kNotCalibrated);
  if (!std::isfinite(sample.t) || !velocity.allFinite() || !covariance.allFinite()) {
    return counted(AddStatus::kNotFinite);
  }
  if (velocity.norm() > kMaxSpeed) return counted(AddStatus::kGlitch);
  if (!isPositiveDefinite(covariance)) {
    return counted(AddStatus::kNoCovariance);
  }
  if (options_.live && std::abs(sample.t - newest_) > kJump) {
    return counted(AddStatus::kStray);
  }
  if (sample.t <= last_speed_) {
    return counted(AddStatus::kOutOfOrder);
  }
  last_speed_ = sample.t;
  return counted(AddStatus::kAdded);
}

void StreamCheck::forgetTimes() {
  imu_ = Stream();
  frames_ = Stream();
  newest_ = last_speed_ = kNotComputed;
}

// Comparisons with NaN are false: nothing is confirmed, late or stale before it is known.
AddStatus StreamCheck::checkTime(double t, bool restart_on_gap, Stream* stream) {
  if (!options_.live) return t <= stream->last ? AddStatus::kOutOfOrder : use(t, stream);
  const double ahead = t - newest_;
  const bool is_old = ahead > kLate && std::abs(t - before_) < ahead;
  if (stream->follows_jump && (is_old || std::abs(ahead) > kJump)) {
    if (std::isnan(stream->first_stale)) stream->first_stale = t;
    if (std::abs(t - stream->first_stale) <= kPatience) return AddStatus::kBeforeJump;
  }
  if (std::isnan(stream->last)) return use(t, stream);
  const double step = t - stream->last;
  if (step > 0.0 && step <= kJump) return use(t, stream);
  if (step <= 0.0 && step > -kJump) {
    if (!(t > stream->late)) stream->late_since = t;
    stream->late = t;
    return t - stream->late_since < kLate ? AddStatus::kOutOfOrder : restart(t, stream);
  }
  const bool is_gap = step > 0.0;
  const bool by_its_stream = t > stream->stray && t - stream->stray <= kJump;
  const bool by_the_other = is_gap && !restart_on_gap && std::abs(t - newest_) <= kJump;
  if (!by_its_stream && !by_the_other) {
    stream->stray = t;
    return AddStatus::kStray;
  }
  return is_gap && !restart_on_gap ? use(t, stream) : restart(t, stream);
}

AddStatus StreamCheck::use(double t, Stream* stream) {
  *stream = Stream();
  stream->last = t;
  if (!(newest_ >= t)) newest_ = t;
  return AddStatus::kAdded;
}

AddStatus StreamCheck::restart(double t, Stream* stream) {
  before_ = t < newest_ ? newest_ : kNotComputed;
  forgetTimes();
  imu_.follows_jump = frames_.follows_jump = true;
  use(t, stream);
  return AddStatus::kRestarted;
}

}  // namespace slim_init
