// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// One solve of an initializer, on a snapshot of its data. Needs no lock: nothing that the
// initializer receives meanwhile reaches it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimation/state_factor.h"
#include "slim_init/consistency_check.h"
#include "slim_init/init_window.h"
#include "slim_init/keyframe_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/state_prior.h"
#include "slim_init/window_solver.h"
#include "slim_init/work_budget.h"
#include "verdict/rest.h"

namespace slim_init {

/// The last rest of the body that is not older than a window.
struct LastRest {
  StatePrior prior;             ///< shortly before the rest was last seen
  double since = kNotComputed;  ///< begin of the rest [s]; NaN: there is none
  double until = kNotComputed;  ///< newest frame that is at rest [s]
};

/// What the solves of one stream leave to the next ones.
class SolveMemory {
 public:
  /// `full_span_s`: WindowOptions::fullSpan().
  explicit SolveMemory(double full_span_s)
      : answers(full_span_s, ConsistencyCheck::kMaxDisagreement) {}

  ConsistencyCheck answers;
  double last_solved = kNotComputed;  ///< newest keyframe [s]
  LastRest rest;
  double rest_searched = kNotComputed;  ///< newest frame among those searched for a rest [s]
};

/// Solves one snapshot.
class SnapshotSolve {
 public:
  /// `short_window`: the keyframes of provisional estimates, or none. `memory`: of the solves
  /// before; this one is added to it. References are kept.
  SnapshotSolve(const WindowSolver& solver, const std::optional<WindowOptions>& short_window,
                const InitializerOptions& options, KeyframeWindow window, const Priors& priors,
                SolveMemory* memory);

  /// IInitializer::initialize().
  InitResult solve();

 private:
  /// A state from before the failure against the estimate of the window alone.
  struct HealthyState {
    const StatePrior* prior;
    StateTest test;  ///< nothing is contradicted if they cannot be compared
    bool agrees() const { return !test.contradicts(); }
  };

  InitResult start();
  InitResult recover();
  WindowCut withKnownSensors(WindowCut cut) const;
  WindowCut cutSince(double first) const;
  InitResult checked(InitResult result) const;
  void searchRest();
  TimeSpan restWithin(double first, double last, RestMeasures* rest) const;
  bool restUntil(double last);
  InitResult stationary() const;
  std::optional<InitResult> solveFromRest();
  InitResult solveNewest();
  InitResult answer(const InitWindow& window);
  void solveEarlier(int keyframes, const InitResult& result);
  void offerProvisional(InitResult* result);
  InitResult solveWithPrior(const StatePrior& prior);
  std::vector<HealthyState> usableStates(std::string* problem) const;
  StateTest compare(const StatePrior& healthy, const InitResult& alone) const;
  const HealthyState& bestPrior(const std::vector<HealthyState>& states) const;
  StatePrior carried(const StatePrior& prior, double t) const;
  std::string checkHealthy(const StatePrior& healthy) const;
  std::string checkGap(double from, double to) const;
  InitResult continueFrame(const std::vector<HealthyState>& states, InitResult alone) const;
  void continueFrom(const HealthyState& healthy, InitResult* result) const;

  const WindowSolver& solver_;
  const std::optional<WindowOptions>& short_window_;
  const InitializerOptions& options_;
  KeyframeWindow window_;
  const std::vector<StatePrior>& healthy_;
  const KnownSensors known_;
  SolveMemory& memory_;
  std::vector<ImuSample> imu_;
  WorkBudget budget_;
};

}  // namespace slim_init
