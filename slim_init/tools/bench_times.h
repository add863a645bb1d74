// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init_bench times`, `growth` and `count`: times of whole solves as tables.
#pragma once

#include <string>
#include <vector>

namespace slim_init::tools {

/// Whether the arguments begin with one of the commands above.
bool isTimesCommand(const std::vector<std::string>& arguments);

/// Runs the command. Returns the exit code.
int runTimesCommand(const std::vector<std::string>& arguments);

}  // namespace slim_init::tools
