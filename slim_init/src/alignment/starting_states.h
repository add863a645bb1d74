// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Starting points of the refinement: linear solutions with known rotations.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "alignment/reverse_alignment.h"
#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "translation/ligt.h"

namespace slim_init {

/// Tight start: the IMU's centres C(x) = A x + c0 put straight into the visual equations,
///   min over x of (C^T H C - lambda |C - mean C|^2) / (spread^2 lambda / observations)
///                 + |b_a|^2 / sigma_ba^2,   |g| fixed,
/// in closed form (He et al. 2023 solve it without the second term). H carries noise, which adds
/// lambda |C|^2 to the expected cost and so shrinks C and the scale; lambda, the value of H at the
/// visual shape of unit spread, is taken out again. `shape_b0` and `H_b0` as in alignReverse().
/// valid == false where the problem is singular or not finite.
ReverseEstimate alignTight(const LinearMotion& motion, const Eigen::Matrix3Xd& shape_b0,
                           const Eigen::MatrixXd& H_b0, int observations, double gravity_magnitude,
                           double accel_bias_prior);

/// The starts asked for in `use` that succeed, the reverse alignment (positions from the visual
/// shape) before the tight one. `pre` at the gyroscope bias of the starts, with derivatives;
/// `translation` valid, in the frame of the first camera.
std::vector<WindowState> startingStates(const InitWindow& window,
                                        const std::vector<Preintegration>& pre,
                                        const TranslationEstimate& translation,
                                        const SlimOptions& use,
                                        const ReverseAlignmentOptions& options,
                                        const InertialOptions& inertial);

/// The same from the tracks that consistentTracks() finds to agree only, or none when all agree or
/// too few do. `R_c0_ck`: rotation of camera k into the first camera.
std::vector<WindowState> consistentStartingStates(const InitWindow& window,
                                                  const std::vector<Preintegration>& pre,
                                                  const std::vector<Eigen::Matrix3d>& R_c0_ck,
                                                  const SlimOptions& use,
                                                  const AlignmentOptions& alignment,
                                                  const ReverseAlignmentOptions& reverse,
                                                  const InertialOptions& inertial);

}  // namespace slim_init
