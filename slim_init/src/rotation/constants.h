// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Numbers of the rotation stage that are not options: each with its unit and why it is what it is.
#pragma once

#include <iterator>
#include <vector>

namespace slim_init {

/// Cutoffs c of the robust weights in successive rounds of re-weighting, in standard deviations of
/// a residual. The first ones are wide where the start may be wrong.
using CutoffSchedule = std::vector<double>;

namespace rotation_constants {

// ---- Keyframe pairs (keyframe_pairs.h)

/// Distances [keyframes] between the two keyframes of a pair. The derivative of a rotation by the
/// bias grows with the gap while its noise does not; doubling it keeps the number of pairs low.
inline constexpr int kGaps[] = {1, 2, 4, 8};
inline constexpr int kLongestGap = *(std::end(kGaps) - 1);
/// Pairs with fewer common points are neither used nor tested.
inline constexpr int kMinPointsPerPair = 6;
/// Gap [keyframes] over which a camera has turned enough to say something of the calibration, a
/// bias still unknown turns it little, and the tracks have not yet drifted: that of the first bias
/// and of the rotations that are freed.
inline constexpr int kShortGap = 2;
/// Largest gap [keyframes] at which observations are tested and a bias is rated: a wrong one shows
/// at long gaps, but over longer ones the rotation is less certain and clean tracks have drifted.
inline constexpr int kLongGap = 4;
/// How far [rad/s] the bias may be from where the gyro was integrated: the correction of first
/// order is then wrong by less than 1e-6 rad over two seconds, a hundredth of what the points know.
inline constexpr double kRelinearizeTolerance = 1e-3;

// ---- Residuals and baselines (keyframe_pairs.h)

/// Floor of the variance of a residual over that of a bearing, |e x f|^2 summed over both views. A
/// point nearer to the baseline than this has noise of second order that the weight, of first
/// order, does not know.
inline constexpr double kMinNoise = 1e-2;
/// Mean squared residual [sigma^2] below which a baseline needs no rival; that of good data is one.
inline constexpr double kGoodEnough = 1.3;

// ---- Minimisation over the bias (multi_gap_bias.h)

/// Prior of the baseline in its elimination, in variances of a bearing: half of one keeps the
/// Hessian regular where the parallax is of the order of the noise (docs/derivation.md, 1.1).
inline constexpr double kBaselinePriorSigmas2 = 0.5;
/// Rotation and direction of travel of a pair, fitted to its points; fewer, counted by their
/// weight, do not determine them.
inline constexpr int kPairUnknowns = 5;
/// Keyframes, and points in every pair two keyframes apart, from which consecutive pairs stay out
/// of the minimisation: they add a third to the time and then little to the bias.
inline constexpr int kMinKeyframesToSkip = 8;
inline constexpr int kPointsToSkip = 25;
/// Expected decrease at which a round ends, relative to the cost, a chi-square of a thousand: a
/// thousandth of a standard deviation of the bias in the last round, a tenth before.
inline constexpr double kCostTolerance = 1e-9;
inline constexpr double kRoundTolerance = 1e-5;
/// Variance of a vanishing direction that its covariance does not contain [rad^2]: buildings are
/// not built to better than a milliradian.
inline constexpr double kVpModelVariance = 1e-6;
/// A larger bias is a numerical failure [rad/s].
inline constexpr double kMaxBias = 1.0;

// ---- Consensus (robust_bias.h)

/// With a smaller share of agreeing observations there is no consensus.
inline constexpr double kMinInlierFraction = 0.3;
/// A solution is clean and kept from this fraction of agreeing observations on, and below this mean
/// truncated squared residual [sigma^2]. Right solutions of clean windows have 0.9, one in ten 1.1;
/// wrong minima mostly 1.2 to 2.4.
inline constexpr double kCleanInlierFraction = 0.97;
inline constexpr double kCleanCost = 1.15;

// ---- Freed rotations (free_rotations.h)

/// With a wider cutoff than this the known baseline is not trusted [sigma].
inline constexpr double kWideCutoff = 5.0;
/// Largest correction [rad], 17 deg; more is a wrong minimum.
inline constexpr double kLargestCorrection = 0.3;

// ---- Check of the calibration (calibration_check.h)

/// Rotations of the gyroscope itself, vibration and scale error [rad]: no pair is more exact.
inline constexpr double kRotationFloor = 1e-3;
/// Rounds of re-weighting; the weights of a dozen pairs have settled by then.
inline constexpr int kRounds = 5;
/// Pairs of three equations for seven unknowns, with one over for a check.
inline constexpr int kMinPairs = 4;

// ---- Noise of the tracks and readout time (calibration_check.h)

/// With fewer residuals their spread is not estimated.
inline constexpr int kMinNoiseResiduals = 40;
/// Share of its variance that a Gaussian has within kOutlierSigmas.
inline constexpr double kVarianceWithinCutoff = 0.9733;
/// From the median on the standard deviation has settled to a percent after so many rounds.
inline constexpr int kNoiseRounds = 10;
/// Median of the square of a Gaussian.
inline constexpr double kMedianOfSquare = 0.45494;
/// Factor on the variance of the readout time: a point is in two pairs, and a track that drifts is
/// wrong in all of them alike.
inline constexpr double kReadoutInflation = 2.0;
/// The longest readout time of a camera [s]; one that is known to worse than half of it is not
/// known.
inline constexpr double kLargestReadout = 0.04;

// ---- Extrinsic rotation from nothing (extrinsic_rotation.h)

/// How well the turns of both sensors agree under the right extrinsic rotation [rad]: a gyroscope
/// bias of 0.05 rad/s over 0.25 s, an error of td of 30 ms in a rate that changes by 0.5 rad/s.
inline constexpr double kTurnSigma = 0.02;
/// Solutions for rotation, bias and td about the rotation found before; from the one that most
/// pairs agree with two corrections are exact to a tenth of a degree.
inline constexpr int kHandEyeRounds = 4;
/// Largest correction [rad] of that rotation: along an axis about which nothing is known any one is
/// as good as none.
inline constexpr double kMaxHandEyeStep = 0.5;
/// The first rotation has to be this good [deg]; from there the rotation stage finds the rest.
inline constexpr double kMaxHandEyeSigmaDeg = 15.0;

// ---- Pruning (track_pruning.h)

/// A point with a larger residual disagrees with the bias [sigma].
inline constexpr double kAgreementSigmas = 3.5;
/// Factor on the squared residual that a link over more than kShortGap keyframes may have.
inline constexpr double kLongLinkInflation = 2.0;

// ---- Static tracks (track_pruning.h)

/// Motion of a far point by the rotation alone above which a track that stays in its place stands
/// in the image and not in the scene [standard deviations of a bearing]: 12 px.
inline constexpr double kTurnedSigmas = 20.0;
/// Share of the tracks from which on they are taken out. Windows of a rigid scene have less.
inline constexpr double kMinStaticFraction = 0.05;
/// Share above which none stands: the gyroscope has a glitch, or the images do not change.
inline constexpr double kMaxStaticFraction = 0.5;

// ---- Schedules of re-weighting

/// Start from a bias of zero at short gaps.
inline const CutoffSchedule kNarrowStart = {3.0, 3.0};
/// Freed rotations where the bias looks clean, and where the calibration may be degrees off: 40 are
/// 24 px, what eight degrees of extrinsic rotation make of a quick turn.
inline const CutoffSchedule kFreeFromClean = {3.0};
inline const CutoffSchedule kFreeFromFar = {40.0, 10.0, 3.0, 3.0};

}  // namespace rotation_constants
// ---- Work (WorkBudget)

/// Work of one bias per keyframe; of one pass per common point of a pair; and of one iteration per
/// pair [units].
inline constexpr double kWorkPerKeyframe = 30.0;
inline constexpr double kWorkPerPoint = 0.15;
inline constexpr double kWorkPerPair = 0.35;

}  // namespace slim_init
