// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/baselines/options.h"
#include "slim_init/window_solver.h"

namespace slim_init::baselines {

/// `drt-t`: He, Xu, Ouyang, Li, "A Rotation-Translation-Decoupled Solution for Robust and Efficient
/// Visual-Inertial Initialization", CVPR 2023, the tightly-coupled variant with the parameters of
/// the published release. The accelerometer bias is taken as zero; no gates of its own.
class DrtT : public WindowSolver {
 public:
  DrtT(const InitializerOptions& options, const BaselineOptions& baseline_options)
      : options_(options), baseline_options_(baseline_options) {}
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;

 private:
  InitializerOptions options_;
  BaselineOptions baseline_options_;
};

}  // namespace slim_init::baselines
