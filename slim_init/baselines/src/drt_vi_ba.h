// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/baselines/options.h"
#include "slim_init/window_solver.h"

namespace slim_init::baselines {

/// `drt-vi-ba`: DRT-l, refined by the structureless visual-inertial bundle adjustment of Song,
/// Richard, Olivares-Mendez, "Improving Monocular Visual-Inertial Initialization with Structureless
/// Visual-Inertial Bundle Adjustment", 2025 (epipolar_bundle_adjustment.h). No gates of its own.
class DrtViBa : public WindowSolver {
 public:
  DrtViBa(const InitializerOptions& options, const BaselineOptions& baseline_options)
      : options_(options), baseline_options_(baseline_options) {}
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;

 private:
  InitializerOptions options_;
  BaselineOptions baseline_options_;
};

}  // namespace slim_init::baselines
