// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "ab_options.h"

namespace slim_init::tools {

/// `slim_init ab --suite`: runs the cases, those that are finished already excepted, and writes the
/// paper's tables. Returns the exit code: that of the first case that could not be run, if any.
int runSuite(AbOptions options);

}  // namespace slim_init::tools
