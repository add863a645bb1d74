// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init_bench soak`: one host for a day, with faults in its streams, faster than real time.
#pragma once

#include <string>
#include <vector>

namespace slim_init::tools {

/// Runs the command with the arguments after its name. Returns the exit code: 1 where memory, the
/// time of a question or the number of answers drifts beyond its bound.
int runSoakCommand(const std::vector<std::string>& arguments);

}  // namespace slim_init::tools
