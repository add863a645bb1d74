// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is known of the sensors, from one run to the next.
#pragma once

#include <string>

#include "slim_init/state_prior.h"
#include "slim_init/types.h"

namespace slim_init {

/// Writes `known`, learned at `stamp` [s], as a YAML file: the old one stays until the new one is
/// whole. `configured`: the rig of the host's file, to which the calibration belongs. False and a
/// message naming the file in `error` (may be null) where it cannot be written.
bool saveSensorsFile(const std::string& path, const Calibration& configured, double stamp,
                     const KnownSensors& known, std::string* error);

/// The inverse. Where the file belongs to another rig than `configured` (another extrinsic or td),
/// the calibration is discarded. False, everything as it was, and a message naming file, key, value
/// and bound in `error` (may be null) where it cannot be read or says what cannot be.
bool loadSensorsFile(const std::string& path, const Calibration& configured, double* stamp,
                     KnownSensors* known, std::string* error);

}  // namespace slim_init
