// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Numbers of the alignment that are not options: each with its unit and why it is what it is.
#pragma once

namespace slim_init::alignment_constants {

// ---- Consistent tracks (consistent_tracks.h)

/// A track agrees up to this many standard deviations, root mean square of its residuals.
inline constexpr double kAgreementSigmas = 3.0;
/// Floor of the distance to a point [m]: a row is divided by it.
inline constexpr double kMinDistance = 1e-3;
/// Rows turn into angles by distances that the first pass finds; the second one uses them.
inline constexpr int kDistancePasses = 2;
/// Factor from one surrogate of the truncated loss to the next, as Yang et al. 2020.
inline constexpr double kGraduation = 1.4;
/// Control parameter mu from which the surrogate is the truncated loss to a thousandth.
inline constexpr double kTruncated = 1e3;
/// 1.4^40 = 7e5: mu reaches kTruncated from any start above 1.5e-3.
inline constexpr int kMaxGraduations = 40;

// ---- Reverse alignment (reverse_alignment.h)

/// Scales searched [m per unit of the shape], and points of the logarithmic grid between them.
inline constexpr double kMinScale = 0.02;
inline constexpr double kMaxScale = 50.0;
inline constexpr int kScaleGrid = 36;
/// Weight of the length of the trajectory (kappa), in units of the mean diagonal of the
/// information.
inline constexpr double kLengthWeight = 1e3;
/// End of the search [log scale].
inline constexpr double kLogScaleTolerance = 1e-5;

// ---- Fixed norm of gravity (gravity_constrained.h)

/// With a unit diagonal a pivot below this is rounding: the unknown is not determined.
inline constexpr double kMinPivot = 1e-14;
/// Steps on the secular equation: Newton needs a few, the bisection that guards it at most sixty.
inline constexpr int kMaxSecularSteps = 100;

}  // namespace slim_init::alignment_constants
