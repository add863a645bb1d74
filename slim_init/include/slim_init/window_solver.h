// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The mathematics behind an initializer.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"

namespace slim_init {

/// A method that turns one window into one answer. Pure and deterministic: equal windows give equal
/// results (wall-clock times excepted), whatever was solved before. Never throws, prints or exits;
/// const calls may run in parallel.
class WindowSolver {
 public:
  virtual ~WindowSolver() = default;
  /// The name under which makeWindowSolver() finds it.
  virtual const std::string& name() const = 0;
  virtual InitResult solve(const InitWindow& window) const = 0;
};

/// Names accepted by makeWindowSolver(), in the order in which reports list them.
const std::vector<std::string>& solverNames();

/// Makes a solver by name. Unknown name or invalid options: null, and a sentence in `error`.
std::unique_ptr<WindowSolver> makeWindowSolver(const std::string& name,
                                               const InitializerOptions& options,
                                               std::string* error = nullptr);

}  // namespace slim_init
