// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/baselines/baselines.h"

namespace slim_init::baselines {

/// `openvins`: the dynamic initializer of OpenVINS (Geneva et al. 2020), which is the closed form
/// of Dong-Si and Mourikis, "Estimator initialization in vision-aided inertial navigation with
/// unknown camera-IMU calibration", IROS 2012, and a maximum-likelihood refinement of it. Refuses
/// as the release does; a refusal comes without an estimate.
class OpenVins : public WindowSolver {
 public:
  OpenVins(const OpenVinsOptions& options, const GateOptions& gates)
      : options_(options), gates_(gates) {}
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;

 private:
  OpenVinsOptions options_;
  GateOptions gates_;
};

}  // namespace slim_init::baselines
