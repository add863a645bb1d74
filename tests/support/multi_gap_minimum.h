// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "rotation/multi_gap_bias.h"

namespace slim_init::testing_support {

/// Gyroscope bias [rad/s] of the lowest cost over all gaps from a bias of zero, no track pruned, no
/// vanishing points.
inline Eigen::Vector3d multiGapMinimum(const InitWindow& window,
                                       const RobustBiasOptions& options = RobustBiasOptions(),
                                       const InertialOptions& inertial = InertialOptions()) {
  const CutoffSchedule schedule = {{10.0, 5.0, 3.0, 3.0}, 4};
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  MultiGapProblem problem(window, nullptr, options, inertial);
  Baselines baselines = problem
                            .findBaselines(zero, options.max_gap, {*schedule.begin()},
                                           unknownBaselines(problem.pairs()))
                            .baselines;
  return problem.minimize(zero, options.max_gap, schedule, {}, baselines).gyro_bias;
}

}  // namespace slim_init::testing_support
