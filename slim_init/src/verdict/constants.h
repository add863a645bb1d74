// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier:
// BSD-3-Clause
//
// Numbers of the verdict that are not options: each with its unit and why it is what it is.
#pragma once

#include <cmath>

namespace slim_init::verdict_constants {

inline constexpr double kDegPerRad = 180.0 / M_PI;

// ---- Gates (gates.h)

/// Windows with fewer keyframes have the bound max_inertial_chi2_short.
inline constexpr int kShortWindow = 8;
/// Metres per unit of the trajectory below which a scale is no motion at all [m].
inline constexpr double kMinScale = 1e-6;
/// Share of its bound from which a missing parallax is forgiven where every other gate passes.
inline constexpr double kForgivenParallax = 0.5;

// ---- Check of the calibration (calibration_check.h)

/// Standard deviations before any data: a right angle, half a second and what no gyroscope has.
inline constexpr double kExtrinsicPrior = M_PI / 2;  // [rad]
inline constexpr double kTdPrior = 0.5;              // [s]
inline constexpr double kBiasPrior = 0.5;            // [rad/s]
/// Rotations of the gyroscope itself, vibration and scale error [rad]: no pair is more exact.
inline constexpr double kRotationFloor = 1e-3;
/// The rate at an instant is the mean of the samples this close [s]: five at 200 Hz.
inline constexpr double kRateSpan = 0.012;
/// Rounds of re-weighting; the weights of a dozen pairs have settled by then.
inline constexpr int kRounds = 5;
/// Cauchy scale of a pair, standard deviations per axis.
inline constexpr double kCutoffSigmas = 3.0;
/// Pairs of three equations for seven unknowns, with one over for a check.
inline constexpr int kMinPairs = 4;

}  // namespace slim_init::verdict_constants
