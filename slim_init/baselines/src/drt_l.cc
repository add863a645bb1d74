// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "compared_methods.h"
#include "gyro_bias.h"
#include "loosely_coupled.h"

namespace slim_init::baselines {

InitResult solveDrtL(const InitWindow& window, const InitializerOptions& options,
                     const BaselineOptions& /*baseline_options*/) {
  InitResult result;
  StageClock clock(&result);
  if (!startResult(window, &result)) return result;

  // Gyroscope bias from the epipolar planes of consecutive keyframes (section 4.1).
  const GyroBiasEstimate bias = estimateGyroBias(window, GyroBiasProblem());
  clock.lap("gyro_bias");
  if (!acceptGyroBias(bias, &result)) return result;

  // Translations up to scale, then velocities, gravity and scale linearly (section 4.2).
  solveTranslationAndAlign(window, LineTerms(), options, &clock, &result);
  return result;
}

}  // namespace slim_init::baselines
