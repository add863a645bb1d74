// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "simulate_options.h"

namespace slim_init::tools {

/// `slim_init simulate`: renders a motion through a scene and writes images, IMU data, truth and
/// the scene itself. Returns the exit code.
int runSimulate(const SimulateOptions& options);

}  // namespace slim_init::tools
