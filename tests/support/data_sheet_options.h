// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slim_init/options.h"

namespace slim_init {

/// A simulated IMU is as good as its data sheet.
inline InertialOptions dataSheetNoise() {
  InertialOptions inertial;
  inertial.accel_noise_factor = 1.0;
  inertial.gyro_noise_factor = 1.0;
  return inertial;
}

/// Options for draws from the model (drawnFromTheModel()).
inline InitializerOptions dataSheetOptions() {
  InitializerOptions options;
  options.inertial = dataSheetNoise();
  return options;
}

}  // namespace slim_init
