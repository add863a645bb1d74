// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The estimator started from a method's estimate, over the seconds that follow it.
#pragma once

#include "slim_init/backend/options.h"
#include "slim_init/backend/sliding_window_estimator.h"
#include "slim_init/evaluation/downstream.h"

namespace slim_init::backend {

/// How a seed is followed by the back end.
struct DownstreamOptions {
  double seconds = 5.0;           ///< after the last keyframe of the seed
  double frame_interval_s = 0.1;  ///< between the frames that the estimator sees; a host's 10 Hz
  double max_error_m = 1.0;       ///< a position error above this, once aligned, is a divergence
  double min_spread_m = 0.05;     ///< a last window that moved less, rms, shows no scale
  EstimatorOptions estimator;
  FailureOptions failure;
};

/// Seeds the estimator with the states of `answer` at their frames of `sequence` (the newest ten of
/// them where there are more), runs it over the frames that follow, the same for every method, and
/// compares the newest states, as they came out, with the ground truth at their times. It goes on
/// with `answer.calibration` if there is one, else with sequence.calibration; td is not estimated
/// any more. A provisional estimate seeds its newest state alone, with its covariance as prior. An
/// estimate without states does not run. A run that ends early because the data end counts as far
/// as it got, when at least half of the seconds were there.
evaluation::DownstreamRecord runDownstream(const evaluation::Sequence& sequence,
                                           const InitResult& answer,
                                           const DownstreamOptions& options);

/// |s - 1| with ground truth = s R states + t; NaN where the ground truth moved less than
/// `min_spread_m`.
double windowScaleError(const std::vector<NavState>& states, const std::vector<NavState>& truth,
                        double min_spread_m);

}  // namespace slim_init::backend
