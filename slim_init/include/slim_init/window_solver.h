// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The mathematics behind an initializer.
#pragma once

#include <memory>
#include <string>

#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/state_prior.h"
#include "slim_init/work_budget.h"

namespace slim_init {

/// A method that turns one window into one result. Pure and deterministic: equal windows give equal
/// results (wall-clock times excepted), whatever was solved before, as far as the budget is counted
/// equally (WorkLimits::work_per_ms). Never throws, prints or exits;
/// const calls may run in parallel.
class WindowSolver {
 public:
  virtual ~WindowSolver() = default;
  /// Name of the method, e.g. "slim".
  virtual const std::string& name() const = 0;
  virtual InitResult solve(const InitWindow& window) const = 0;
  /// The same as a part of the work of one call, whose other solves share `budget` (not null). A
  /// method that does not bound its work keeps this default.
  virtual InitResult solveWithin(const InitWindow& window, WorkBudget* /*budget*/) const {
    return solve(window);
  }
  /// An estimate for a host that takes a prior, from a window that is too short to know its scale:
  /// kProvisional with the covariance of the states, or a refusal. A method without one keeps this
  /// default, kTooFewKeyframes.
  virtual InitResult solveProvisional(const InitWindow& /*window*/, WorkBudget* /*budget*/) const {
    InitResult none;
    none.status = InitStatus::kTooFewKeyframes;
    none.message = name() + " has no provisional estimates";
    return none;
  }
  /// Whether solveWithPrior() is more than its default.
  virtual bool usesPriors() const { return false; }
  /// An estimate from a window whose first keyframe's state is known (`prior.state.t` is its time),
  /// in the world of the prior: four keyframes can be enough, at constant velocity and in hover
  /// too. Parts of the prior that the data contradict are not used and named in
  /// InitResult::prior_dropped; without the velocity it is a refusal. A method without such
  /// estimates keeps this default, kTooFewKeyframes.
  virtual InitResult solveWithPrior(const InitWindow& /*window*/, const StatePrior& /*prior*/,
                                    WorkBudget* /*budget*/) const {
    InitResult none;
    none.status = InitStatus::kTooFewKeyframes;
    none.message = name() + " cannot use a prior";
    return none;
  }
};

/// Makes `slim`, the method of this library. Invalid options: null, and a message in `error` (may
/// be null).
std::unique_ptr<WindowSolver> makeSlimSolver(const InitializerOptions& options,
                                             std::string* error = nullptr);

}  // namespace slim_init
