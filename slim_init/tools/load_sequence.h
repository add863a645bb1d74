// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Where evaluation and simulation meet: a sequence out of a recording or a built-in motion.
#pragma once

#include <string>

#include "ab_options.h"
#include "slim_init/evaluation/sequence.h"

namespace slim_init::tools {

struct LoadedSequence {
  evaluation::Sequence sequence;
  std::string gyro_bias_truth;  ///< "recorded", "fitted" or "simulated"
};

/// Reads --recorded or simulates --builtin, and projects the world at the image times. Returns an
/// empty string, or a sentence naming file, line, value or option.
std::string loadSequence(const AbOptions& options, LoadedSequence* loaded);

}  // namespace slim_init::tools
