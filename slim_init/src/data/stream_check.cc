// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/stream_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <type_traits>

#include "geometry/dense.h"

namespace slim_init {

StreamCounts& StreamCounts::operator+=(const StreamCounts& other) {
  // Counts and nothing else: as an array of them, in which none is forgotten.
  std::array<std::int64_t, sizeof(StreamCounts) / sizeof(std::int64_t)> sum, more;
  static_assert(sizeof(sum) == sizeof(StreamCounts) && std::is_trivially_copyable_v<StreamCounts>);
  std::memcpy(sum.data(), this, sizeof(sum));
  std::memcpy(more.data(), &other, sizeof(more));
  std::transform(sum.begin(), sum.end(), more.begin(), sum.begin(), std::plus<>());
  std::memcpy(this, sum.data(), sizeof(sum));
  return *this;
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
  switch (status) {
    case AddStatus::kAdded:
    case AddStatus::kRestarted: ++counts_.imu_added; break;
    case AddStatus::kNotFinite: ++counts_.imu_not_finite; break;
    case AddStatus::kGlitch: ++counts_.imu_glitches; break;
    case AddStatus::kStray: ++counts_.imu_stray; break;
    case AddStatus::kBeforeJump: ++counts_.imu_before_jump; break;
    default: ++counts_.imu_out_of_order;
  }
  return status;
}

AddStatus StreamCheck::checkFrame(double t) {
  AddStatus status = AddStatus::kNotFinite;
  if (std::isfinite(t)) status = checkTime(t, options_.restart_on_frame_gap, &frames_);
  switch (status) {
    case AddStatus::kAdded:
    case AddStatus::kRestarted: ++counts_.frames_added; break;
    case AddStatus::kNotFinite: ++counts_.frames_not_finite; break;
    case AddStatus::kStray: ++counts_.frames_stray; break;
    case AddStatus::kBeforeJump: ++counts_.frames_before_jump; break;
    default: ++counts_.frames_out_of_order;
  }
  return status;
}

AddStatus StreamCheck::checkSpeed(const SpeedSample& sample, const SpeedSensor& sensor) {
  const int rows = sample.forward_only ? 1 : 3;
  const auto covariance = sample.covariance.topLeftCorner(rows, rows);
  const auto velocity = sample.velocity.head(rows);
  const auto counted = [](std::int64_t* count, AddStatus status) {
    ++*count;
    return status;
  };
  if (!sensor.calibrated) return counted(&counts_.speeds_not_calibrated, AddStatus::kNotCalibrated);
  if (!std::isfinite(sample.t) || !velocity.allFinite() || !covariance.allFinite()) {
    return counted(&counts_.speeds_not_finite, AddStatus::kNotFinite);
  }
  if (velocity.norm() > kMaxSpeed) return counted(&counts_.speeds_glitches, AddStatus::kGlitch);
  if (!isPositiveDefinite(covariance)) {
    return counted(&counts_.speeds_no_covariance, AddStatus::kNoCovariance);
  }
  if (options_.live && std::abs(sample.t - newest_) > kJump) {
    return counted(&counts_.speeds_stray, AddStatus::kStray);
  }
  if (sample.t <= last_speed_) {
    return counted(&counts_.speeds_out_of_order, AddStatus::kOutOfOrder);
  }
  last_speed_ = sample.t;
  return counted(&counts_.speeds_added, AddStatus::kAdded);
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
  ++counts_.restarts;
  before_ = t < newest_ ? newest_ : kNotComputed;
  forgetTimes();
  imu_.follows_jump = frames_.follows_jump = true;
  use(t, stream);
  return AddStatus::kRestarted;
}

}  // namespace slim_init
