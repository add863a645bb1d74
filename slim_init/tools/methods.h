// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The methods that the programs run.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/baselines/baselines.h"

namespace slim_init::tools {

struct AbOptions;

/// Names of baselines::allMethods(), in the order in which reports list them.
const std::vector<std::string>& methodNames();

/// A method as it is run and reported.
struct Method {
  std::string name;  ///< in the report; "slim[no-lines]" of a variant
  std::unique_ptr<WindowSolver> solver;
  std::string note;  ///< of a variant
};

/// The methods of --methods, each followed by its variants with --ablation (ablation.cc).
std::vector<Method> makeMethods(const AbOptions& options);

}  // namespace slim_init::tools
