// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/sequence.h"

#include <algorithm>
#include <cmath>

namespace slim_init::evaluation {

NavState truthAt(const Sequence& sequence, double t) {
  if (!sequence.has_truth || sequence.truth.size() != sequence.frames.size() || !std::isfinite(t)) {
    return NavState();
  }
  constexpr double kSameTime = 1e-9;  // the same but for the rounding of sums [s]
  // By the frames: where there is no truth, its t is NaN and cannot be searched.
  const double td = sequence.trueCalibration().td;
  const auto found = std::lower_bound(
      sequence.frames.begin(), sequence.frames.end(), t - kSameTime,
      [td](const FrameObservation& frame, double time) { return frame.t + td < time; });
  if (found != sequence.frames.end() && found->t + td <= t + kSameTime) {
    return sequence.truth[static_cast<std::size_t>(found - sequence.frames.begin())];
  }
  return sequence.truth_between ? sequence.truth_between(t) : NavState();
}

}  // namespace slim_init::evaluation
