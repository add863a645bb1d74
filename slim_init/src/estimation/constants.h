// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Numbers of the estimation that are not options: each with its unit and why it is what it is.
#pragma once

namespace slim_init::estimation_constants {

// ---- Minimisation (visual_inertial_problem.h)

/// Damping of a track's own parameters, relative to its largest information, and its floor: where
/// the views do not determine one of them (the distance of a far point), it stays where it is.
inline constexpr double kTrackDamping = 1e-7;
inline constexpr double kMinTrackInformation = 1e-6;
/// Information that holds a bias, or an inverse depth, at zero, 1 / (1e-6 m/s^2)^2.
inline constexpr double kHold = 1e12;
/// Marquardt damping, relative to the diagonal of the information: at the start, its floor after
/// good steps, and where another step is pointless.
inline constexpr double kFirstDamping = 1e-6;
inline constexpr double kSmallestDamping = 1e-9;
inline constexpr double kLargestDamping = 1e8;
/// Damping is at least this much after a step that was refused, and after a matrix that was not
/// positive definite: from the smallest one it would take four refusals to matter.
inline constexpr double kDampingAfterRefusal = 1e-5;
inline constexpr double kDampingAfterFailure = 1e-4;
/// A step shorter than this squared length [sigma^2] that is refused is tried again with the tracks
/// held that got worse; a longer one is damped.
inline constexpr double kNearMinimum = 4.0;
/// A first minimisation goes on to this squared length of a step [sigma^2]: noise and outliers are
/// told from its residuals, and a second one follows.
inline constexpr double kRoughTolerance = 1.0;
/// Keyframes of a line: two views do not constrain the motion.
inline constexpr int kMinLineViews = 3;
/// A cost that rises by less than this share is equal: rounding of its sum.
inline constexpr double kCostRounding = 1e-12;

// ---- Window (refine_window.h)

/// What gross errors among the tracks may make of the chi-square in the right minimum, as a factor
/// on that of a wrong one: beyond it another minimum is looked for, since the gate would refuse.
inline constexpr double kGrossErrors = 1.5;

/// Median of the length of a 2-vector of independent unit Gaussians, sqrt(2 ln 2).
inline constexpr double kRayleighMedian = 1.17741;
/// Median of the larger of two independent unit |Gaussians|.
inline constexpr double kMaxOfTwoMedian = 1.05;
/// First-order biases are exact enough below this [rad/s].
inline constexpr double kRelinearizeGyro = 5e-3;
/// A time offset is first-order exact enough below this [s]: accelerations of 10 rad/s^2 turn the
/// body by 5e-6 rad more than the mean rate says.
inline constexpr double kRelinearizeTd = 1e-3;

// ---- Posterior (posterior.h)

/// Step of the central differences of the attitude by the direction of gravity [rad]: good to 1e-9.
inline constexpr double kGravityStep = 1e-5;

// ---- Known state (state_factor.h)

/// Standard deviations of the parts of a state (StatePart) of which nothing is known: velocity of a
/// fast vehicle [m/s], attitude [rad], biases of the worst sensors [rad/s, m/s^2].
inline constexpr double kUnknown[] = {30.0, 1.0, 0.3, 1.0};
/// Data whose information is a smaller share of the prior's than this say nothing against it.
inline constexpr double kLeastInformation = 1e-3;
/// On the bounds of the test, squared errors beyond the covariance: those of model errors of tracks
/// and IMU, and, for all that a wrong velocity or tilt bends, of the linearisation too.
inline constexpr double kBiasTestMargin = 1.5;
inline constexpr double kStateTestMargin = 2.25;

// ---- Measured velocities (speed_factor.h)

/// Re-weightings of the speeds and their common error at one state: an error that the motion
/// contradicts is free after these.
inline constexpr int kSpeedScalePasses = 12;
/// A speed, or their common error, with a smaller weight is contradicted: 3.6 standard deviations.
inline constexpr double kContradictedSpeed = 0.17;

// ---- Work (WorkBudget)

/// Work of a linearisation per view, per pair of views of a track (with a rolling shutter), per
/// keyframe, and per cube of the number of unknowns [units]: fitted to the times of 5 to 25
/// keyframes with 30 to 250 points, 10 % off on average.
inline constexpr double kWorkPerView = 0.1;
inline constexpr double kWorkPerPairOfViews = 0.0115;
inline constexpr double kWorkPerRollingPair = 0.07;
inline constexpr double kWorkPerKeyframe = 2.1;
inline constexpr double kWorkOfSolve = 3.7e-6;

}  // namespace slim_init::estimation_constants
