// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "load_sequence.h"

namespace slim_init::tools {

/// Reads --asl or --bag and tracks points and lines through its images, with a progress bar and the
/// debug images of --frames. Returns an empty string, or a sentence naming file, line, value or
/// option; in a build without feature_tracker_lines always a sentence.
std::string loadImages(const AbOptions& options, LoadedSequence* loaded);

}  // namespace slim_init::tools
