// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slim_init/work_budget.h"

namespace slim_init {

/// For tests of what a solver finds when nothing ends it.
inline WorkBudget unlimitedBudget() {
  WorkLimits limits;
  limits.max_solve_ms = 0.0;
  return WorkBudget(limits);
}

}  // namespace slim_init
