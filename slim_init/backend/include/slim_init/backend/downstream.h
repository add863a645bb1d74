// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The estimator started from a method's estimate, over the seconds that follow it.
#pragma once

#include "slim_init/evaluation/protocol.h"

namespace slim_init::backend {

/// Seeds the estimator with the states of `answer` at their frames of `sequence` (the newest ten of
/// them where there are more), runs it over the frames of the `seconds` that follow, the same for
/// every method, and compares the newest states, as they came out, with the ground truth at their
/// times. It goes on with `answer.calibration` if there is one, else with the one `given`; td
/// is not estimated any more. An estimate without states does not run; of a provisional one the
/// covariance is not used. A run that ends early
/// because the data end counts as far as it got, when at least half of the seconds were there.
evaluation::DownstreamRecord runDownstream(const evaluation::Sequence& sequence,
                                           const Calibration& given, const InitResult& answer,
                                           double seconds);

/// |s - 1| with ground truth = s R states + t; NaN if the ground truth moved less than 0.05 m, rms.
double windowScaleError(const std::vector<NavState>& states, const std::vector<NavState>& truth);

}  // namespace slim_init::backend
