// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "doctor_options.h"

namespace slim_init::tools {

/// `slim_init doctor`: why does an estimator not initialize on this recording? Prints a table of
/// findings. Returns 0 when nothing is wrong, 1 with warnings, 2 with errors; also 2 when it cannot
/// do its work (unreadable input, --json that cannot be written, out of memory), with a message on
/// stderr, so that 1 always means warnings.
int runDoctor(const DoctorCommand& command);

}  // namespace slim_init::tools
