// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/window_solver.h"
#include "slim_init/work_budget.h"

namespace slim_init {

/// The answer of `solve` to a window with Calibration::imu_biases (docs/derivation.md, 5.4). A bias
/// adds to the samples, so that a known one is a change of origin: it is taken off the samples,
/// what is left of it has a prior about zero with the standard deviation of the knowledge, and the
/// answer gets it back. `solve` is asked as it is where nothing is known beyond the priors of
/// `options`; and again where the data contradict what is known, or nothing fits it: that answer
/// says so in its warnings.
InitResult answerAboutKnownBiases(const InitWindow& window, const SolveRequest& request,
                                  const InitializerOptions& options, WorkBudget* budget,
                                  InitResult (*solve)(const InitWindow&, const SolveRequest&,
                                                      const InitializerOptions&, WorkBudget*));

}  // namespace slim_init
