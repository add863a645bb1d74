// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A window seen through another calibration.
#pragma once

#include <memory>

#include "slim_init/init_window.h"

namespace slim_init {

/// The window as it had been cut with `calibration`: keyframe times move by the change of td, row
/// times by that of readout_s (in proportion). Keyframes that the IMU samples do not cover there,
/// at either end, are left out with all their sightings; a track keeps its id and needs two
/// sightings. Null where fewer than two keyframes are left or `calibration` is not valid.
std::shared_ptr<const InitWindow> withCalibration(const InitWindow& window,
                                                  const Calibration& calibration);

}  // namespace slim_init
