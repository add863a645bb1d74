// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "load_sequence.h"

namespace slim_init {
struct Config;
}
namespace slim_init::evaluation {
class ImageSequence;
}

namespace slim_init::tools {

/// Without --config: camera and calibration that lie beside the data, and the keys of --options on
/// top (`options_file`, may be empty). `source`: the recording as the user named it. Returns an
/// empty string, or a sentence naming what is missing or wrong. Only in a build with
/// feature_tracker_lines.
std::string configureFromData(const std::string& source, const std::string& options_file,
                              const evaluation::ImageSequence& images, Config* config);

/// Reads --asl or --bag and tracks points and lines through its images, with a progress bar.
/// Returns an empty string, or a sentence naming file, line, value or option; in a build without
/// feature_tracker_lines always a sentence.
std::string loadImages(const AbOptions& options, LoadedSequence* loaded);

}  // namespace slim_init::tools
