// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/baselines/baselines.h"

namespace slim_init::baselines {

/// `vins`: the loosely-coupled initializer of VINS-Mono (Qin and Shen, "Robust initialization of
/// monocular visual-inertial estimation on aerial robots", IROS 2017; Qin, Li, Shen, "VINS-Mono",
/// T-RO 2018, section V). The accelerometer bias is taken as zero. Refuses as the release does; a
/// refusal comes without an estimate.
class Vins : public WindowSolver {
 public:
  Vins(const VinsOptions& options, const GateOptions& gates, const WindowOptions& window)
      : options_(options), gates_(gates), window_(window) {}
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;

 private:
  VinsOptions options_;
  GateOptions gates_;
  WindowOptions window_;
};

}  // namespace slim_init::baselines
