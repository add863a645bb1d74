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

/// What a window is solved for; empty: an estimate whose scale is known.
struct SolveRequest {
  /// State of the body at the first keyframe (`state.t` is its time): the estimate is in its world,
  /// and four keyframes can be enough, at constant velocity and in hover too. Parts of it that the
  /// data contradict are not used and named in InitResult::prior_dropped; without the velocity,
  /// or without two parts, it is a refusal. Has to outlive the solve; null: not known.
  const StatePrior* first_state = nullptr;
  /// For a host that takes a prior, from a window that is too short to know its scale: kProvisional
  /// with the covariance of the states, or a refusal. Not with a first state.
  bool provisional = false;
};

/// A method that turns one window into one result. Pure and deterministic: equal windows give equal
/// results (wall-clock times excepted), whatever was solved before, as far as the budget is counted
/// equally (WorkLimits::work_per_ms). Never throws, prints or exits;
/// const calls may run in parallel.
class WindowSolver {
 public:
  virtual ~WindowSolver() = default;
  /// Name of the method, e.g. "slim".
  virtual const std::string& name() const = 0;
  /// Whether it solves more than the empty request.
  virtual bool usesPriors() const { return false; }

  /// `budget` is shared by all solves of one call; null: this solve has the limits of the method's
  /// options. kTooFewKeyframes for a request that the method does not solve.
  InitResult solve(const InitWindow& window, const SolveRequest& request = {},
                   WorkBudget* budget = nullptr) const {
    if (usesPriors() || !(request.first_state || request.provisional)) {
      return solveWindow(window, request, budget);
    }
    InitResult none;
    none.status = InitStatus::kTooFewKeyframes;
    none.message =
        name() + (request.first_state ? " cannot use a prior" : " has no provisional estimates");
    return none;
  }

 protected:
  /// The method. One that does not bound its work ignores `budget`.
  virtual InitResult solveWindow(const InitWindow& window, const SolveRequest& request,
                                 WorkBudget* budget) const = 0;
};

/// Makes `slim`, the method of this library. Invalid options: null, and a message in `error` (may
/// be null).
std::unique_ptr<WindowSolver> makeSlimSolver(const InitializerOptions& options,
                                             std::string* error = nullptr);

}  // namespace slim_init
