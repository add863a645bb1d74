// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Numbers of the line stage that are not options: each with its unit and why it is what it is.
#pragma once

namespace slim_init::lines_constants {

// ---- Vanishing points (vanishing_point.h)

/// The longest lines of a keyframe, of which every two give a direction to vote for. Of a direction
/// that a fifth of the lines share eight are among them.
inline constexpr int kIntersectedLines = 40;
/// Rounds of selecting inliers and fitting. Two suffice as a rule, the set then repeats itself.
inline constexpr int kMaxRounds = 4;
/// The direction d is held, across the sphere, by how far the planes differ: least along the second
/// eigenvector v of the mean of w n n^T, whose eigenvalue l2 is the mean square of n . v. Against
/// it stand the mean square error of n . d and of n . v, as expected from the noise of the end
/// points, and l1, the mean square of what the fit leaves of n . d. At ten times each of them
/// - the standard deviation of d along v, about sqrt(var(n . d) / (m l2)) for m lines, is below
///   0.32 / sqrt(m) rad, small enough for the first order on which the
///   covariance rests, and
/// - at most a tenth of l2 is noise that poses as conditioning. Below, the planes are one bundle of
/// near-parallel image lines and d lies anywhere along v.
inline constexpr double kMinDetermination = 10.0;
/// The same for noise-free input [rad^2]: planes that differ by less than 1e-4 rad (a twentieth of
/// a pixel) differ by nothing an image can show.
inline constexpr double kMinPlaneSpread = 1e-4 * 1e-4;
/// Squared sine between the end points of a segment; InitWindow leaves out those below 1e-6 rad.
inline constexpr double kMinSquaredSine = 1e-12;

// ---- Line tracks (line_track.h, line_agreement.h)

/// Gauss-Newton steps before views are said to disagree: the linear line leans on the view in the
/// middle, which may be a short segment.
inline constexpr int kGaussNewtonSteps = 2;
/// Their damping, relative to the largest information: holds what the views do not determine.
inline constexpr double kLineDamping = 1e-6;

}  // namespace slim_init::lines_constants
