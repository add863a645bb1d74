// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Numbers of the module that are not options: each with its unit and why it is what it is.
#pragma once

namespace slim_init::scale_constants {

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
/// Information that holds the shape along itself (kappa), in units of its mean diagonal: stiff
/// enough that the rest cannot stretch it, far from what rounding allows.
inline constexpr double kLengthWeight = 1e3;
/// End of the search [log scale].
inline constexpr double kStartTolerance = 1e-5;

// ---- Profile of the scale (scale_profile.h)

/// Scales searched and integrated over: up to this many times larger and smaller. Wrong minima that
/// were accepted lay a factor of 2.4 to 30 away.
inline constexpr double kMaxRatio = 32.0;
/// Points of the grid on each side: steps of 0.29 in the log scale, finer than the distance of two
/// minima worth telling apart.
inline constexpr int kHalfGrid = 12;
/// First step of the search for the end of the interval [log scale]: half the sigma of a good
/// window.
inline constexpr double kFirstStep = 0.01;
/// End of all searches [log scale]: a tenth of the smallest sigma.
inline constexpr double kLogScaleTolerance = 2e-3;

// ---- Integral over the scale (integrateScale())

/// Points of one pass, and passes: each covers what the one before found the density in.
inline constexpr int kIntegralPoints = 32;
inline constexpr int kIntegralPasses = 3;
/// Less than this below its largest value the logarithm of the density is nothing.
inline constexpr double kNegligible = 12.0;

// ---- Fixed norm of gravity (gravity_constrained.h)

/// With a unit diagonal a pivot below this is rounding: the unknown is not determined.
inline constexpr double kMinPivot = 1e-14;
/// Steps on the secular equation: Newton needs a few, the bisection that guards it at most sixty.
inline constexpr int kMaxSecularSteps = 100;

}  // namespace slim_init::scale_constants
