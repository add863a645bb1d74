// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The methods of a run, and what they are worth with one ingredient changed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ab_options.h"
#include "slim_init/baselines/options.h"
#include "slim_init/window_solver.h"

namespace slim_init::tools {

/// One way to change a method.
struct AblationVariant {
  const char* method;    ///< "slim"
  const char* name;      ///< "no-lines", reported as "slim[no-lines]"
  const char* sentence;  ///< what is changed
  void (*change)(InitializerOptions* options, baselines::BaselineOptions* baselines);
};

/// All variants, in the order of the reports.
const std::vector<AblationVariant>& ablationVariants();

/// A method as it is run and reported.
struct Method {
  std::unique_ptr<WindowSolver> solver;  ///< its name() is the name in the report
  std::string note;                      ///< of a variant
};

/// The methods of --methods, each followed by its variants with --ablation. Returns an empty
/// string, or a sentence.
std::string makeMethods(const AbOptions& options, std::vector<Method>* methods);

}  // namespace slim_init::tools
