// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init_bench faults`: starts of a host whose streams are at fault, as a table.
#pragma once

#include <string>
#include <vector>

namespace slim_init::tools {

/// Runs the command with the arguments after its name. Returns the exit code.
int runFaultsCommand(const std::vector<std::string>& arguments);

}  // namespace slim_init::tools
