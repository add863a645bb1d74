// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/window_solver.h"

namespace slim_init {

/// `slim`, the default: points, line segments and vanishing points without any 3D structure as
/// state. Consensus gyroscope bias and track pruning, up-to-scale translations, alignment of the
/// IMU to the visual shape, structureless visual-inertial refinement, verdict from the posterior
/// (docs/derivation.md).
class Slim : public WindowSolver {
 public:
  explicit Slim(const InitializerOptions& options) : options_(options) {}
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;
  InitResult solveWithin(const InitWindow& window, WorkBudget* budget) const override;
  InitResult solveProvisional(const InitWindow& window, WorkBudget* budget) const override;
  bool usesPriors() const override { return true; }
  InitResult solveWithPrior(const InitWindow& window, const StatePrior& prior,
                            WorkBudget* budget) const override;

 private:
  InitializerOptions options_;
};

}  // namespace slim_init
