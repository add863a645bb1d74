// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "ab_options.h"

namespace slim_init::tools {

/// Reads the section `slim_init:` of options->options_file into options->initializer and says what
/// it changed (file_values) and what has no effect here (file_notes). Returns an empty string, or a
/// sentence naming file, key, value and bound; also in a build without feature_tracker_lines.
std::string readOptionsFile(AbOptions* options);

}  // namespace slim_init::tools
