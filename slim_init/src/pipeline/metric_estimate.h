// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// From a window with known rotations to its metric estimate (docs/derivation.md, 3 to 5): start,
// minimum under the priors of the window, covariance, cost over the scale.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimation/posterior.h"
#include "estimation/refine_window.h"
#include "imu/window_state.h"
#include "lines/line_track.h"
#include "pipeline/solver_support.h"
#include "scale/scale_profile.h"
#include "shape/ligt.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"

namespace slim_init {

/// The line tracks that agree with `start`; all of them where lines are not pruned or not used.
std::vector<Track> believedLines(const InitWindow& tracks, const WindowState& start,
                                 const InitializerOptions& options);

/// Maximum a posteriori estimate from `start`. `again`: a second search follows if the first
/// minimum looks wrong, within the budget.
RefinedWindow searchMinimum(const RefinementInput& input, const std::vector<Track>& lines,
                            const WindowState& start, bool again);

/// Outcome of the metric steps.
struct MetricEstimate {
  std::optional<WindowState> start;
  RefinedWindow refined;
  Posterior posterior;                    ///< of `refined`, of the rig as well; valid if that is
  std::optional<ScaleProfile> profile;    ///< if other scales were looked for
  ScaleMoments scale;                     ///< with a prior on the motion
  StateVector known_residual;             ///< estimate minus known state
  std::vector<std::string> contradicted;  ///< parts of the known state that were not used
  bool contradicts_biases = false;        ///< the data do, WindowPriors::biases

  const ScaleProfile* profileOrNull() const { return profile ? &*profile : nullptr; }
};

/// The priors of `input` decide. A known state gives the start and the scale. A prior on the motion
/// makes an estimate over all scales that it and the data allow. Without either the start is the
/// reverse alignment of `translation`, and other minima and scales are searched for as well, unless
/// the estimate cannot be accepted (`can_pass`).
MetricEstimate estimateMetric(RefinementInput input, const TranslationEstimate& translation,
                              const InitializerOptions& options, bool can_pass, StageClock* clock);

/// Moves states and covariance of `result`, those of the refined window, to mean and covariance
/// over the scale.
void moveToMean(const ScaleMoments& scale, const Posterior& posterior, InitResult* result);

}  // namespace slim_init
