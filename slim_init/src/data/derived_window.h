// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Windows made from another one: under another calibration, without speeds or observations.
#pragma once

#include <memory>
#include <vector>

#include "slim_init/init_window.h"
#include "slim_init/result.h"

namespace slim_init {

/// The window itself: a pointer that does not own it.
std::shared_ptr<const InitWindow> unowned(const InitWindow& window);

/// The window as it had been cut with `calibration`: keyframe times move by the change of td.
/// Keyframes that the IMU samples do not cover there, at either end, are left out with all their
/// observations; a track keeps its id and needs two observations. Null where fewer than two
/// keyframes are left or `calibration` is not valid.
std::shared_ptr<const InitWindow> withCalibration(const InitWindow& window,
                                                  const Calibration& calibration);

/// The window without its measured velocities.
std::shared_ptr<const InitWindow> withoutSpeeds(const InitWindow& window);

/// `calibration` with the extrinsics that were found elsewhere, and with their td where it has a
/// variance. Their standard deviations replace those of `calibration`, but are not wider (a host's
/// own covariance may be none) and not below 0.05 deg, 1 mm and 0.1 ms.
Calibration withFound(const Calibration& calibration, const CalibrationEstimate& found);

/// What becomes of an observation.
enum ObservationVerdict : char { kDropObservation = 0, kKeepObservation = 1 };

/// The window with the kept point observations only. `keep`: one ObservationVerdict per
/// observation, indexed as InitWindow::pointObservations(). Tracks left with one observation are
/// dropped. Everything else (times, calibration, IMU samples, lines, counts) is shared with
/// `window` and not copied; it lives as long as either window. Null when `keep` has another size
/// than pointObservations().
std::shared_ptr<const InitWindow> withObservations(const InitWindow& window,
                                                   const std::vector<char>& keep);

}  // namespace slim_init
