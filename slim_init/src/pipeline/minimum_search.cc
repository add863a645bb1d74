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

// With fewer point tracks it is searched again in any case.
constexpr int kFewTracks = 50;

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
  // If the minimum does not fit, from the inertial trajectory that most tracks agree with: the
  // shape may have been none. If it fits, but with few tracks, from the shape of those that agree
  // with each other: one bad track among a dozen biases the minimum without a larger residual.
  const auto other = [&](bool fit) -> std::optional<WindowState> {
    if (fit && input.tracks.pointTracks().size() >= kFewTracks) return std::nullopt;
    if (!input.budget.allows("the search of another minimum")) return std::nullopt;
    return fit ? consistentStartingState(input.tracks, input.pre, input.inertial)
               : inertialStartingState(input.tracks, input.pre, input.inertial);
  };
  return refineWindow(input, lines, start, other);
}

}  // namespace slim_init
