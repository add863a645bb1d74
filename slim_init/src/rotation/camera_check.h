// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What keyframe pairs say about the camera itself: the noise of its tracks and an error of its
// readout time, where each pair has the rotation and the direction of travel that its own points
// see, so that neither scale nor motion, bias, extrinsic or td matter (docs/derivation.md, 6.1).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rotation/free_rotations.h"
#include "rotation/keyframe_pairs.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// The longest readout time of a camera [s]; one that is known to worse than half of it is not
/// known.
inline constexpr double kLargestReadout = 0.04;

/// Standard deviation of a bearing across its epipolar plane [rad], by noiseVariance() of the
/// residuals, with what the fit of each pair took taken back. NaN with fewer than
/// kFewestForSpread. `rotations`: freeRotations() of `pairs`.
double trackNoise(const KeyframePairs& pairs, const std::vector<RelativeRotation>& rotations);

/// An error of the readout time.
struct ReadoutCheck {
  bool valid = false;
  double error_s = 0.0;  ///< true readout less that of the window's calibration [s]
  double sigma_s = 0.0;  ///< its standard deviation [s]
};

/// The readout time that makes the epipolar residuals smallest: one step from the rotations and
/// baselines of the pairs, which are eliminated. `window`: the rows are compensated at the readout
/// time of its calibration; `gyro_bias` [rad/s]; `sigma` [rad] of a bearing, for the weights. Not
/// valid where the camera does not turn, or where no rows are known.
ReadoutCheck checkReadout(const InitWindow& window, const KeyframePairs& pairs,
                          const std::vector<RelativeRotation>& rotations,
                          const Eigen::Vector3d& gyro_bias, double sigma);

}  // namespace slim_init
