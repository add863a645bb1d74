// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tracks_options.h"

namespace slim_init::tools {

/// `slim_init tracks`: runs the front end over a sequence and reports how many features it tracks,
/// for how long, in what time and, where the scene is known, how accurately. Returns the exit code.
int runTracks(const TracksOptions& options);

}  // namespace slim_init::tools
