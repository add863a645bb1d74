// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The answer of a window at whose beginning a state is known (docs/derivation.md, 5.3).
#pragma once

#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/state_prior.h"
#include "slim_init/work_budget.h"

namespace slim_init {

/// WindowSolver::solveWithPrior() of `slim`.
InitResult recoveredAnswer(const InitWindow& window, const StatePrior& prior,
                           const InitializerOptions& options, WorkBudget* budget);

}  // namespace slim_init
