// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <vector>

#include "slim_init/evaluation/sequence.h"
#include "slim_init/host_health/imu_screen.h"
#include "slim_init/init_window.h"
#include "slim_init/initializer.h"

namespace slim_init::evaluation {

/// The streams of a sequence from one frame on, as a host receives them, into one initializer. The
/// references are kept.
class StreamStart {
 public:
  StreamStart(const Sequence& sequence, std::size_t frame, const ImuLimits& limits,
              IInitializer* initializer)
      : sequence_(sequence), initializer_(initializer), screen_(limits) {
    const double t = timeOf(frame) - InitWindow::kImuMargin;
    const auto after =
        std::upper_bound(sequence.imu.begin(), sequence.imu.end(), t,
                         [](double time, const ImuSample& sample) { return time < sample.t; });
    next_ = after == sequence.imu.begin() ? after : std::prev(after);
    speed_ =
        std::lower_bound(sequence.speeds.begin(), sequence.speeds.end(), t,
                         [](const SpeedSample& sample, double time) { return sample.t < time; });
  }

  /// Time of a frame on the IMU clock [s].
  double timeOf(std::size_t frame) const {
    return sequence_.calibration.imuTime(sequence_.frames[frame].t);
  }

  /// Frames ascend.
  void add(std::size_t frame) {
    const double t = timeOf(frame) + InitWindow::kImuMargin;
    while (next_ != sequence_.imu.end() && !(t_imu_ >= t)) {
      t_imu_ = next_->t;
      screen_.pass(*next_++,
                   [this](const ImuSample& sample) { return initializer_->addImu(sample); });
    }
    for (; speed_ != sequence_.speeds.end() && speed_->t < t; ++speed_) {
      initializer_->addSpeed(*speed_);
    }
    initializer_->addFrame(sequence_.frames[frame]);
  }

 private:
  const Sequence& sequence_;
  IInitializer* initializer_;
  host_health::ImuScreen screen_;
  std::vector<ImuSample>::const_iterator next_;
  std::vector<SpeedSample>::const_iterator speed_;
  double t_imu_ = -1e300;
};

}  // namespace slim_init::evaluation
