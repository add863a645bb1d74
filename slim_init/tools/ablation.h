// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The methods of a run, and what they are worth with one ingredient changed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ab_options.h"
#include "slim_init/window_solver.h"

namespace slim_init::tools {

/// A method as it is run and reported.
struct Method {
  std::unique_ptr<WindowSolver> solver;  ///< its name() is the name in the report
  std::string note;                      ///< of a variant
};

/// The methods of --methods, each followed by its variants with --ablation.
std::vector<Method> makeMethods(const AbOptions& options);

}  // namespace slim_init::tools
