// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "other_scale.h"

#include <cmath>
#include <vector>

namespace slim_init {
namespace {

ScaleProfile profileOf(const RefinementInput& input, const InitializerOptions& options,
                       const RefinedWindow& refined) {
  // About the biases of the answer: chained over the window, first order is not exact enough.
  // Between the exposures, td as estimated.
  const InitWindow& window = input.tracks;
  const WindowState& state = refined.state;
  const double shift = coveredShift(window, state.rig.dtd);
  std::vector<Preintegration> pre;
  pre.reserve(input.pre.size());
  for (std::size_t k = 0; k < input.pre.size(); ++k) {
    pre.push_back(preintegrate(window.imu(), window.times()[k] + shift,
                               window.times()[k + 1] + shift, state.gyro_bias, state.accel_bias,
                               ImuNoise(), PreintegrationParts::kMean));
    // The covariance depends on the biases by a hundredth of itself.
    pre.back().covariance = input.pre[k].covariance;
  }
  return profileScale(ScaleCost(refined, pre, input.tracks.calibration(), options.inertial));
}

// The same shape in another size; velocities follow, gravity and biases are left to the refinement.
WindowState resized(WindowState state, double ratio) {
  state.p_b0 *= ratio;
  state.v_b0 *= ratio;
  return state;
}

}  // namespace

ScaleProfile searchOtherScale(const RefinementInput& input, const AgreeingLines& lines,
                              const InitializerOptions& options, RefinedWindow* refined,
                              Posterior* posterior) {
  ScaleProfile profile = profileOf(input, options, *refined);
  if (!profile.valid || std::abs(profile.log_ratio) < ScaleProfile::kSameBasin) return profile;
  // Without lines where the answer has none: its cost is compared.
  const std::vector<Track> tracks = refined->line_tracks > 0 ? lines.tracks : std::vector<Track>();
  RefinedWindow here = *refined;
  makeCostExact(input, tracks, options, &here);
  const RefinedWindow other =
      refineWindow(input.tracks, tracks, input.pre, input.vanishing_points,
                   {resized(refined->state, std::exp(profile.log_ratio))}, StartMode::kFine,
                   options.refinement, options.inertial, input.rig);
  if (!other.valid || !(other.cost < here.cost)) return profile;
  const Posterior of_other = posteriorOf(input.tracks, other);
  if (!of_other.valid) return profile;
  *refined = other;
  *posterior = of_other;
  return profileOf(input, options, *refined);
}

}  // namespace slim_init
