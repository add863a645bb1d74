// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A window with some of its point observations taken out or some of its point tracks cut.
#pragma once

#include <memory>
#include <vector>

#include "slim_init/init_window.h"

namespace slim_init {

/// What becomes of an observation. Kept observations are nonzero.
enum ObservationVerdict : char {
  kDropObservation = 0,
  kKeepObservation = 1,
  /// Kept, but the track jumped before it: it starts a track of its own.
  kStartTrack = 2,
};

/// The window with the kept point observations only. `keep`: one ObservationVerdict per
/// observation, indexed as InitWindow::pointObservations(). Tracks left with one observation are
/// dropped, cut tracks become two with the same id. Everything else (times, calibration, IMU
/// samples, lines, counts) is shared with `window` and not copied; it lives as long as either
/// window. Null when `keep` has another size than pointObservations().
std::shared_ptr<const InitWindow> withObservations(const InitWindow& window,
                                                   const std::vector<char>& keep);

}  // namespace slim_init
