// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// How much one call of an initializer may compute.
#pragma once

#include <string>

#include "slim_init/options.h"

namespace slim_init {

/// Counts the work of one call and says when it has to end. Work is counted in units, not in time,
/// so that equal data give equal results; WorkLimits::work_per_ms makes time of them. A unit is
/// about a microsecond of a desktop processor. Belongs to one call; not thread-safe.
class WorkBudget {
 public:
  /// Of WorkLimits that validate() accepts.
  explicit WorkBudget(const WorkLimits& limits);

  void spend(double units) { used_ += units; }
  double used() const { return used_; }  ///< units
  bool isUsedUp() const { return used_ >= limit_; }

  /// False if the budget is used up; then `search` is noted as skipped.
  bool allows(const char* search);
  /// Notes that a search was skipped, or ended before its time. The first one counts.
  void leaveOut(const char* search);
  /// The skipped searches and the reason, as a sentence; then forgotten. "" if there is nothing.
  std::string takeLeftOut();

  /// Restricts a budget to a fraction of what is left of it beside `reserve` [units], for as long
  /// as it lives: what follows has the rest.
  class Share {
   public:
    Share(double share, WorkBudget* budget, double reserve = 0.0);
    ~Share() { budget_.limit_ = limit_; }
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

   private:
    WorkBudget& budget_;
    double limit_;
  };

 private:
  double max_solve_ms_;
  double limit_;  // units
  double used_ = 0.0;
  std::string left_out_;
};

/// The limits of a host that runs in real time: without a given rate, that of this processor.
WorkLimits liveLimits(WorkLimits limits);

/// Units of work that this processor does in a millisecond, from a short fixed computation;
/// measured at the first call of a process.
double measuredWorkPerMs();

}  // namespace slim_init
