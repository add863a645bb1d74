// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/window_solver.h"

namespace slim_init {

/// `drt-l`: the loosely-coupled variant of "A Rotation-Translation-Decoupled Solution for Robust
/// and Efficient Visual-Inertial Initialization" (He et al., CVPR 2023). Points only.
class DrtL : public WindowSolver {
 public:
  explicit DrtL(const InitializerOptions& options) : options_(options) {}
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;

 private:
  InitializerOptions options_;
};

}  // namespace slim_init
