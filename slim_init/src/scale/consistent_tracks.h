// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Which point tracks agree with one inertial trajectory. Known-rotation pruning uses two views at a
// time and accepts a point that slides along its epipolar line; one such track among a dozen is
// enough to lead the alignment into a wrong minimum.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "scale/reverse_alignment.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// The inertial trajectory that most tracks agree with.
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

}  // namespace slim_init
