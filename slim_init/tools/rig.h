// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slim_init/types.h"

namespace slim_init::tools {

/// The EuRoC rig (Burri et al. 2016): left camera and ADIS16448 IMU. Recordings of --recorded and
/// the built-in motions use it alike.
Calibration eurocCalibration();

}  // namespace slim_init::tools
