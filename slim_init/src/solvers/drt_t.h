// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/window_solver.h"

namespace slim_init {

/// `drt-t`: He, Xu, Ouyang, Li, "A Rotation-Translation-Decoupled Solution for Robust and Efficient
/// Visual-Inertial Initialization", CVPR 2023, the tightly-coupled variant with the parameters of
/// the published release. The accelerometer bias is taken as zero; no gates of its own.
class DrtT : public WindowSolver {
 public:
  explicit DrtT(const InitializerOptions& options) : options_(options) {}
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;

 private:
  InitializerOptions options_;
};

}  // namespace slim_init
