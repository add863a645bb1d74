// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Starting point of the refinement: a linear solution with known rotations.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "scale/reverse_alignment.h"
#include "shape/ligt.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// The inertial trajectory that most tracks agree with. Known-rotation pruning uses two views at a
/// time and accepts a point that slides along its epipolar line; one such track among a dozen is
/// enough to lead the alignment into a wrong minimum.
struct ConsistentTracks {
  Eigen::Matrix<double, 9, 1> x;  ///< [v_0, b_a, g] in b0 [m/s, m/s^2, m/s^2]
  std::vector<char> agrees;       ///< per track of window.pointTracks()
};

/// Finds it, and the tracks that agree with it; none where the problem is singular.
///
/// Derivation: docs/derivation.md, 3.3. The cost of a track over x = [v_0, b_a, g] is the sum of
/// its squared multi-view residuals (LiGT rows as angles) at the centres C(x) = A x + c0, a
/// quadratic of nine unknowns. Truncated least squares over the tracks by graduated non-convexity
/// (Yang et al. 2020), |g| fixed; twice, since rows turn into angles by depths that the first pass
/// finds. Tracks of two views have no rows and agree.
std::optional<ConsistentTracks> consistentTracks(const InitWindow& window,
                                                 const LinearMotion& motion,
                                                 double accel_bias_prior);

/// The reverse alignment, positions from the visual shape; none where it fails. `pre` at the
/// gyroscope bias of the start, with derivatives; `translation` valid, in the frame of the first
/// camera.
std::optional<WindowState> startingState(const InitWindow& window,
                                         const std::vector<Preintegration>& pre,
                                         const TranslationEstimate& translation,
                                         const InertialOptions& inertial);

/// The trajectory that most tracks agree with (consistentTracks()), or none where it fails. It
/// needs no shape, which fast turns over few common tracks do not leave; the noise of the tracks
/// makes it too small, so that it is no start for all windows.
std::optional<WindowState> inertialStartingState(const InitWindow& window,
                                                 const std::vector<Preintegration>& pre,
                                                 const InertialOptions& inertial);

/// startingState() from the tracks that consistentTracks() finds to agree only, or none when all
/// agree or too few do.
std::optional<WindowState> consistentStartingState(const InitWindow& window,
                                                   const std::vector<Preintegration>& pre,
                                                   const InertialOptions& inertial);

}  // namespace slim_init
