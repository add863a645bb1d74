// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The checks of the doctor, each of which appends its findings, good ones too, and what `slim`
// itself makes of the windows of a recording.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "slim_init/doctor/doctor.h"

namespace slim_init::evaluation {

using Findings = std::vector<Finding>;

inline constexpr double kDegPerRad = 57.29577951308232;

/// Cuts windows one after the other, without overlap, and solves each of them twice: with the
/// calibration as configured, for the verdict, and with wide priors about the one that `alignment`
/// has found, for the calibration.
/// The second is left out where camera and gyro do not measure the same motion
/// (`options.min_correlation`, `options.gyro_scale`): no calibration makes them agree.
WindowEstimates solveWindows(const DoctorData& data, const RotationAlignment& alignment,
                             const DoctorOptions& options);

/// The most probable calibration, given independent estimates that all rest on one prior: `prior`,
/// with its sigmas, which counts once. Re-weighted (Cauchy), so that one estimate in ten may be
/// wrong; the covariance is scaled by the scatter of the estimates where that is larger than they
/// say. Nothing for fewer than kMinEstimates or where an estimate has no covariance.
OptionalCalibration combinedCalibration(const std::vector<CalibrationEstimate>& estimates,
                                        const Calibration& prior);
inline constexpr int kMinEstimates = 3;

/// Order, rate, gaps, jitter of the IMU's stamps.
void checkImuStream(const DoctorData& data, const DoctorOptions& options, Findings* findings);
/// Order, rate, gaps of the images' stamps, and whether the IMU covers them.
void checkImageStream(const DoctorData& data, const DoctorOptions& options, Findings* findings);
/// Unit of the accelerometer, gravity, range of the gyro.
void checkImuValues(const DoctorData& data, const RotationAlignment& alignment,
                    const DoctorOptions& options, Findings* findings);
/// Light, saturation, blur, repetition.
void checkImages(const DoctorData& data, const DoctorOptions& options, Findings* findings);
/// Points, their survival, lines.
void checkTracks(const DoctorData& data, const DoctorOptions& options, Findings* findings);
/// Agreement of both rotations, unit and axes of the gyro, time offset, extrinsic. The calibration
/// is that of `answers`; where they have none, what the rotations alone measure. Returns the lines
/// for the host's file of those parts that are off.
std::string checkRotation(const DoctorData& data, const RotationAlignment& alignment,
                          const WindowEstimates& answers, const DoctorOptions& options,
                          Findings* findings);
/// Verdicts of `slim`.
void checkEstimates(const WindowEstimates& answers, const DoctorOptions& options,
                    Findings* findings);
/// Noise of the IMU against the data sheet's.
void checkImuNoise(const DoctorData& data, const WindowEstimates& answers,
                   const DoctorOptions& options, Findings* findings);
/// Whether there is enough motion to initialize.
void checkExcitation(const DoctorData& data, const RotationAlignment& alignment,
                     const WindowEstimates& answers, const DoctorOptions& options,
                     Findings* findings);

/// Severity of a value that must not exceed the bound.
Severity severityAbove(double value, const DoctorOptions::Bound& bound);

/// A finding about a value that must not exceed the bound (atLeast: fall below it). Both are shown
/// in `unit`, of which the unit that they have here holds `factor`.
Finding atMost(const char* check, double value, const DoctorOptions::Bound& bound, const char* unit,
               double factor = 1.0);
Finding atLeast(const char* check, double value, const DoctorOptions::Bound& bound,
                const char* unit, double factor = 1.0);
/// The bound of a value that is never an error.
inline DoctorOptions::Bound warningAt(double limit) {
  return {limit, std::numeric_limits<double>::infinity()};
}
/// One that could not be checked yet.
Finding notChecked(const char* check, const char* unit);

/// A number for a message, without exponent: "0.0123", "9.81", "200".
std::string number(double value, int digits = 3);
/// "1.2 %"
std::string percent(double share);

/// Appends a finding; its advice is that of one that is not kOk. The caller may change it; the
/// reference is valid until the next call.
Finding& add(Findings* findings, Finding finding, const std::string& message = "",
             const std::string& advice = "");

}  // namespace slim_init::evaluation
