// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/baselines/options.h"
#include "slim_init/window_solver.h"

namespace slim_init::baselines {

/// `drt-l`: the loosely-coupled variant of "A Rotation-Translation-Decoupled Solution for Robust
/// and Efficient Visual-Inertial Initialization" (He et al., CVPR 2023). Points only.
class DrtL : public WindowSolver {
 public:
  DrtL(const InitializerOptions& options, const BaselineOptions& baseline_options)
      : options_(options), baseline_options_(baseline_options) {}
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;

 private:
  InitializerOptions options_;
  BaselineOptions baseline_options_;
};

}  // namespace slim_init::baselines
