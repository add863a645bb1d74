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

// Where the minimum does not fit, from the inertial trajectory that most tracks agree with: the
// shape may have been none. Where it fits, but with few tracks, from the shape of those that agree
// with each other: one bad track among a dozen biases the minimum without a larger residual. The
// lowest cost wins.
void searchAgain(const RefinementInput& input, const std::vector<Track>& lines, bool fit,
                 RefinedWindow* refined) {
  if (!input.budget.allows("the search of another minimum")) return;
  const std::optional<WindowState> start =
      fit ? consistentStartingState(input.tracks, input.pre, input.inertial)
          : inertialStartingState(input.tracks, input.pre, input.inertial);
  if (!start) return;
  const RefinedWindow other = refineWindow(input, lines, *start, StartMode::kFine);
  if (other.valid && (!refined->valid || other.cost < refined->cost)) *refined = other;
}

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
  RefinedWindow refined = refineWindow(input, lines, start, StartMode::kRough);
  const bool fit = refined.valid && fits(refined.chi2, refined.median_chi2, input.options);
  if (again && (!fit || input.tracks.pointTracks().size() < kFewTracks)) {
    searchAgain(input, lines, fit, &refined);
  }
  return refined;
}

}  // namespace slim_init
