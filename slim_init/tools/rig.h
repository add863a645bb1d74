// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "ab_options.h"
#include "slim_init/types.h"

namespace slim_init::tools {

/// The EuRoC rig (Burri et al. 2016): left camera and ADIS16448 IMU. Recordings of --recorded and
/// the built-in motions use it alike.
Calibration eurocCalibration();

/// The rig of the simulated features: that of --config where there is one, otherwise EuRoC's.
Calibration rigOf(const AbOptions& options);
/// Its camera, taken as one without distortion.
simulation::PinholeCamera cameraOf(const AbOptions& options);

}  // namespace slim_init::tools
