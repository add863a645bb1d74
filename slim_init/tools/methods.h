// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The methods that the programs know: those of the core, and the compared systems that need more
// than Eigen where they are part of the build.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/options.h"
#include "slim_init/window_solver.h"

namespace slim_init::tools {

/// Names accepted by makeMethod(), in the order in which reports list them.
const std::vector<std::string>& methodNames();

/// Makes a method by name, compared systems with the parameters of their releases. Unknown name or
/// invalid options: null, and a sentence in `error`.
std::unique_ptr<WindowSolver> makeMethod(const std::string& name, const InitializerOptions& options,
                                         std::string* error = nullptr);

/// `slim_init methods`: prints every method with a line on what it is. Returns the exit code.
int runMethods();

}  // namespace slim_init::tools
