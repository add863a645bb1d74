// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/minimum_search.h"

#include <optional>
#include <vector>

#include "scale/starting_states.h"

namespace slim_init {
namespace {

// Departure from one line in space, seen from the start, at which a line track is cut, in standard
// deviations of an end point; leaves a margin for the error of the start.
constexpr double kLineAgreementSigmas = 6.0;

}  // namespace

Posterior posteriorOf(const InitWindow& tracks, const RefinedWindow& refined) {
  const WindowState& state = refined.state;
  return posteriorOf(state, refined.information, tracks.calibration(),
                     imuInstants(tracks, state.rig.dtd, state.gyro_bias, state.accel_bias));
}

std::vector<Track> believedLines(const InitWindow& tracks, const WindowState& start,
                                 const InitializerOptions& options) {
  if (!options.slim.prune_lines || !options.refinement.use_lines) {
    return tracks.lineTracks();
  }
  const double bound = kLineAgreementSigmas * tracks.calibration().sigmaLine();
  return agreeingLineTracks(tracks, start, bound, kMinLineViews);
}

RefinedWindow searchMinimum(const RefinementInput& input, const std::vector<Track>& lines,
                            const WindowState& start, bool again) {
  if (!again) return refineWindow(input, lines, start);
  // The shape may have been none.
  const auto other = [&]() -> std::optional<WindowState> {
    if (!input.budget.allows("the search of another minimum")) return std::nullopt;
    return inertialStartingState(input.tracks, input.pre, input.inertial);
  };
  return refineWindow(input, lines, start, other);
}

}  // namespace slim_init
