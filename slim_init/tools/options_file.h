// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "ab_options.h"

namespace slim_init::tools {

/// Reads --config into options->config and the section `slim_init:` of --options, or else of
/// --config, into options->initializer. Says what the files change (file_values) and what of them
/// has no effect here (file_notes). Returns an empty string, or a sentence naming file, key, value
/// and bound; also in a build without feature_tracker_lines.
std::string readConfiguration(AbOptions* options);

}  // namespace slim_init::tools
