// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The search of the minimum around refineWindow(): which lines are believed, which starts are
// tried, and whether the points agree with the answer (docs/derivation.md, 4.8 and 4.9).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/posterior.h"
#include "estimation/refine_window.h"
#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "lines/line_agreement.h"
#include "lines/vanishing_point.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"

namespace slim_init {

/// What every refinement of a window shares. Keeps references: the arguments outlive it.
struct RefinementInput {
  const InitWindow& tracks;                             ///< points pruned
  const std::vector<Preintegration>& pre;               ///< by preintegrateInflated()
  const std::vector<Eigen::Matrix3d>& R_c0_ck;          ///< camera k to the first camera
  const std::vector<VanishingPoint>* vanishing_points;  ///< or null
  std::optional<RigPrior> rig;                          ///< or the calibration is exact
};

/// The line tracks that agree with the one of `starts` that more of them agree with; all of them
/// where lines are not pruned or not used.
AgreeingLines believedLines(const InitWindow& tracks, const std::vector<WindowState>& starts,
                            const InitializerOptions& options);

/// Maximum a posteriori estimate from `starts` (at least one). A second search follows where the
/// first answer looks wrong, and lines that contradict the points are left out.
RefinedWindow searchMinimum(const RefinementInput& input, const AgreeingLines& lines,
                            const std::vector<WindowState>& starts,
                            const InitializerOptions& options);

/// Minimises again from `refined` where its cost is an upper bound (StartMode::kRough), so that it
/// can be compared with others. `lines` as it was refined with.
void makeCostExact(const RefinementInput& input, const std::vector<Track>& lines,
                   const InitializerOptions& options, RefinedWindow* refined);

/// Posterior of a refined window, of the rig as well where that was estimated.
Posterior posteriorOf(const InitWindow& tracks, const RefinedWindow& refined);

/// The estimate of a window.
struct WindowEstimate {
  RefinedWindow refined;
  Posterior posterior;  ///< valid where the information is positive definite
};

/// searchMinimum() and its posterior; once more with wider priors where the rig found lies beyond
/// its own (widenedByEstimate()), there without the second search where nothing fitted the first
/// time.
WindowEstimate estimateWindow(RefinementInput input, const AgreeingLines& lines,
                              const std::vector<WindowState>& starts, InitializerOptions options);

}  // namespace slim_init
