// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A test host fed from a simulated sequence, frame by frame.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "backend/simulated_sequence.h"
#include "backend/test_host.h"
#include "slim_init/backend/downstream.h"

namespace slim_init::backend {

/// Order statistic of values that may be infinite.
inline double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(share * values.size()))];
}

class HostRun {
 public:
  /// What happens to the data before the host gets them; empty: nothing. A frame filter that
  /// returns false loses the frame.
  std::function<void(ImuSample*)> imu_filter;
  std::function<bool(FrameObservation*)> frame_filter;
  std::function<void(TestHost*, double stamp)> before_frame;

  HostRun(const evaluation::Sequence& sequence, std::size_t first_frame, double max_wait_ms = -1.0)
      : sequence_(sequence), host_(sequence.calibration, max_wait_ms), next_frame_(first_frame) {
    while (next_imu_ + 1 < sequence.imu.size() &&
           sequence.imu[next_imu_ + 1].t <= sequence.frames[first_frame].t) {
      ++next_imu_;
    }
  }

  /// Feeds the next frame with the samples before it; null at the end of the data. A lost frame is
  /// skipped, its samples are not.
  const HostStep* next() {
    while (next_frame_ < sequence_.frames.size()) {
      frame_ = next_frame_++;
      FrameObservation frame = sequence_.frames[frame_];
      while (next_imu_ < sequence_.imu.size() && !(last_imu_ >= frame.t)) {
        ImuSample sample = sequence_.imu[next_imu_++];
        last_imu_ = sample.t;
        if (imu_filter) imu_filter(&sample);
        host_.addImu(sample);
      }
      if (last_imu_ < frame.t) return nullptr;
      if (frame_filter && !frame_filter(&frame)) continue;
      if (before_frame) before_frame(&host_, frame.t);
      step_ = host_.addFrame(frame);
      return &step_;
    }
    return nullptr;
  }

  double stamp() const { return sequence_.frames[frame_].t; }
  NavState truth() const { return truthOfFrame(sequence_, frame_); }
  TestHost& host() { return host_; }

  /// |s - 1| of the window; NaN where it moved less than 5 cm rms or there is none.
  double scaleError() const {
    const std::vector<NavState> states = host_.estimator().states();
    std::vector<NavState> truth;
    for (const NavState& state : states) {
      // Images come at 10 Hz from zero.
      truth.push_back(
          truthOfFrame(sequence_, static_cast<std::size_t>(std::lround(10.0 * state.t))));
    }
    return states.empty() ? kNotComputed : windowScaleError(states, truth);
  }
  double scaleErrorOrZero() const {
    const double error = scaleError();
    return std::isnan(error) ? 0.0 : error;
  }

 private:
  const evaluation::Sequence& sequence_;
  TestHost host_;
  std::size_t next_frame_;
  std::size_t frame_ = 0;
  std::size_t next_imu_ = 0;
  double last_imu_ = -1e300;
  HostStep step_;
};

}  // namespace slim_init::backend
