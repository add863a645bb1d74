// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Numbers of the verdict that are not options: each with its unit and why it is what it is.
#pragma once

namespace slim_init::verdict_constants {

// ---- Gates (gates.h)

/// The certain part of an error of the calibration is the estimate less this many sigma, and beyond
/// as many of prior and estimate together there is a warning.
inline constexpr double kCertainSigmas = 2.5;
/// Without translation: less rotation over the window is stationary, more is pure rotation [deg].
inline constexpr double kMinRotationDeg = 2.0;
/// Without translation: largest deviation of the specific force of a window at rest; above it the
/// vehicle accelerates and the scene is too far away [m/s^2].
inline constexpr double kMaxRestDeviation = 0.5;
/// Least rms angle over which the points of an image are spread [deg].
inline constexpr double kMinPointSpreadDeg = 2.0;
/// Largest change of the velocity over the window by its length [m/s^2]. A quiet motion far from
/// everything also fits a fall along a tilted gravity, with 11; recorded flights have up to 4.
inline constexpr double kMaxMeanAcceleration = 8.0;

// ---- Other scales (scale/scale_profile.h)

/// Least cost of any other minimum above that of the answer [sigma^2]: four standard deviations. Of
/// right answers one in five hundred has another minimum as low, and 40 would refuse no more.
inline constexpr double kMinOtherScaleRise = 16.0;

/// Relative standard deviation of the scale of images and IMU below which the motion shows the
/// scale: at constant velocity it stays above (0.37 to none in the first half second).
inline constexpr double kShownScaleSigma = 0.35;
/// And largest relative change of a velocity that counts as constant, 0.15 there: a change that the
/// wheel sees is one that the IMU measures, half a second later at the latest.
inline constexpr double kSteadyVelocityChange = 0.2;
/// Speeds that have to be there before the scale may rest on them: one that slips among fewer does
/// not show.
inline constexpr int kFewestSpeeds = 3;

// ---- Rest (rest.h)

/// Shortest rest [s]; one of twice that is looked for as well. And time over which IMU samples are
/// averaged to see motion [s]: the vibration of an idling engine is gone in it.
inline constexpr double kRestSpan = 1.0;
inline constexpr double kRestStep = 0.3;
/// Least median length of the noise of a bearing [px]. On images that stand it is below 0.1, and
/// slow errors of the tracker would pass for motion.
inline constexpr double kLeastTrackNoise = 0.4;
/// Fewer tracks over the whole rest say too little: with a dozen, 0.05 m/s pass in one window
/// of 30.
inline constexpr int kFewestTracksAtRest = 20;
/// Motion of the tracks and of the means of the IMU that a second of rest may have, in standard
/// deviations of their noise; two seconds may have twice that: the longer it is seen, the clearer
/// motion is. A rig with idling rotors sways by 2 to 3 in two seconds. At the least, the IMU sees a
/// hover within 3 mm move by 2.1 in one and 3.9 in two seconds, and the tracks 0.05 m/s by 2.0 and
/// 5.7 (false_rest_test).
inline constexpr double kMaxMotionAtRest = 1.8;
/// Standard deviations at rest: velocity [m/s], and what a mean over a rest does not tell about the
/// flight after it, of specific force [m/s^2] (that of MH_04 changes by 0.06 as its rotors speed
/// up) and rate [rad/s].
inline constexpr double kRestVelocitySigma = 0.01;
inline constexpr double kRestForceSigma = 0.05;
inline constexpr double kRestRateSigma = 2e-4;

// ---- Agreement of successive answers (slim_init/consistency_check.h)

/// Two instants are the same when they are this close [s]: nearer than two images.
inline constexpr double kSameInstant = 1e-3;
/// An answer is an earlier one when this much of the data is newer [s]: a keyframe interval, and an
/// image at 10 Hz.
inline constexpr double kMinNewData = 0.09;
/// Answers older than this are forgotten [s]: host and camera may drop some images in between.
inline constexpr double kRemembered = 0.6;
/// Instants that both paths have: two displacements, so that not a single one decides.
inline constexpr int kMinSharedInstants = 3;
/// Relative standard deviation up to which an answer is one that a later answer can agree with. On
/// recorded growing windows any bound between 0.15 and 0.5 keeps out as many wrong answers; a low
/// one makes right ones wait.
inline constexpr double kMaxEarlierSigma = 0.5;
/// Least standard deviation of the difference, as a share of that of the answer: windows of equal
/// length, and sigmas that are only good to a half. Between 0.1 and 1 it makes no difference.
inline constexpr double kAgreementFloor = 0.5;

}  // namespace slim_init::verdict_constants
