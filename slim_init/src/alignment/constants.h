// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Numbers of the alignment that are not options: each with its unit and why it is what it is.
#pragma once

namespace slim_init::alignment_constants {

// ---- Consistent tracks (consistent_tracks.h)

/// A track agrees up to this many standard deviations, root mean square of its residuals.
inline constexpr double kAgreementSigmas = 3.0;
/// Squared sine of the parallax below which a track is not used [rad^2]: 1e-4 rad, the default of
/// AlignmentOptions::min_parallax_rad, is far below the noise of a bearing.
inline constexpr double kMinParallax2 = 1e-8;
/// Floor of the distance to a point [m]: a row is divided by it.
inline constexpr double kMinDistance = 1e-3;
/// Rows turn into angles by distances that the first pass finds; the second one uses them.
inline constexpr int kDistancePasses = 2;
/// Factor from one surrogate of the truncated loss to the next, as Yang et al. 2020.
inline constexpr double kGraduation = 1.4;
/// Control parameter mu from which the surrogate is the truncated loss to a thousandth.
inline constexpr double kTruncated = 1e3;
/// mu where no residual is beyond the bound: above kTruncated, so that nothing is graduated.
inline constexpr double kNothingToTruncate = 1e6;
/// 1.4^40 = 7e5: mu reaches kTruncated from any start above 1.5e-3.
inline constexpr int kMaxGraduations = 40;

// ---- Fixed norm of gravity (gravity_constrained.h)

/// With a unit diagonal a pivot below this is rounding: the unknown is not determined.
inline constexpr double kMinPivot = 1e-14;
/// Steps on the secular equation: Newton needs a few, the bisection that guards it at most sixty.
inline constexpr int kMaxSecularSteps = 100;

}  // namespace slim_init::alignment_constants
