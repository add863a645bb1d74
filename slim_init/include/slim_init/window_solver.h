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
  /// Name of the method, e.g. "slim".
  virtual const std::string& name() const = 0;
  virtual InitResult solve(const InitWindow& window) const = 0;
  /// An answer for a host that takes a prior, from a window that is too young to know its scale:
  /// kProvisional with the covariance of the states, or a refusal. A method without one keeps this
  /// default, kTooFewKeyframes.
  virtual InitResult solveProvisional(const InitWindow& /*window*/) const {
    InitResult none;
    none.status = InitStatus::kTooFewKeyframes;
    none.message = name() + " has no provisional answers";
    return none;
  }
};

/// Makes `slim`, the method of this library. Invalid options: null, and a message in `error` (may
/// be null).
std::unique_ptr<WindowSolver> makeSlimSolver(const InitializerOptions& options,
                                             std::string* error = nullptr);

}  // namespace slim_init
