// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "ab_options.h"

namespace slim_init::tools {

/// `slim_init ab`: load or simulate a sequence, run every method on its windows, report. Returns
/// the exit code.
int runAb(AbOptions options);

}  // namespace slim_init::tools
