// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include "compared_methods.h"
#include "epipolar_bundle_adjustment.h"
#include "estimation/posterior.h"
#include "imu/preintegration.h"
#include "loosely_coupled.h"
#include "pipeline/solver_support.h"
#include "verdict/gates.h"

namespace slim_init::baselines {
namespace {

// Of DRT-l's gates the refinement has changed two: scale and its standard deviation.
void updateGates(double max_scale_sigma, double camera_spread, InitResult* result) {
  for (const GateValue& fresh : alignmentGates(
           {kNotComputed, camera_spread, kNotComputed, result->scale_sigma}, max_scale_sigma)) {
    if (fresh.name != GateName::kScalePositive && fresh.name != GateName::kScaleSigma) continue;
    for (GateValue& gate : result->gates) {
      if (gate.name == fresh.name) gate = fresh;
    }
  }
}

}  // namespace

InitResult solveDrtViBa(const InitWindow& window, const InitializerOptions& options,
                        const BaselineOptions& baseline_options) {
  // DRT-l starts it; what DRT-l cannot answer remains unanswered.
  InitResult result = solveDrtL(window, options, baseline_options);
  if (!result.hasEstimate()) return result;
  StageClock clock(&result);

  // Bundle adjustment without structure: IMU factors and coplanarity of rays and baselines.
  WindowState state = windowStateOf(result.states, window.calibration().gravity_magnitude);
  const std::vector<Preintegration> pre = preintegrateWindow(
      window, state.gyro_bias, state.accel_bias, PreintegrationParts::kWithCovariance);
  const EpipolarAdjustment adjustment =
      adjustEpipolar(window, pre, baseline_options.drt_vi_ba, &state);
  clock.lap("bundle_adjustment");

  if (!adjustment.valid) {
    fail(InitStatus::kNumericalFailure,
         "the bundle adjustment has an IMU covariance or a cost that is not finite", &result);
    result.states.clear();
    return result;
  }
  setWorldStates(window, state, &result);
  const Posterior posterior = posteriorOf(state, adjustment.information);
  result.scale_sigma = posterior.scale_sigma;
  result.covariance = posterior.covariance;
  updateGates(gatesInForce(options.gates, window, options.window).max_scale_sigma,
              cameraSpread(window, state), &result);
  decide(options.gates.mode == GateMode::kOn, &result);
  clock.lap("posterior");
  return result;
}

}  // namespace slim_init::baselines
