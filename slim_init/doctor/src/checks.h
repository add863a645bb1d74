// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The checks of the doctor. Each appends its findings, good ones too.
#pragma once

#include <string>
#include <vector>

#include "slim_init/doctor/doctor.h"

namespace slim_init::evaluation {

using Findings = std::vector<Finding>;

inline constexpr double kDegPerRad = 57.29577951308232;

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
                     const DoctorOptions& options, Findings* findings);

/// Severity of a value that must not exceed the bound (severityBelow: fall below it).
Severity severityAbove(double value, const DoctorOptions::Bound& bound);
Severity severityBelow(double value, const DoctorOptions::Bound& bound);

/// A number for a message, without exponent: "0.0123", "9.81", "200".
std::string number(double value, int digits = 3);
/// "1.2 %"
std::string percent(double share);

/// Appends a finding; the caller fills in message and advice. The reference is valid until the next
/// call.
Finding& add(Findings* findings, const char* check, Severity severity, double value,
             const char* unit);

/// Sets the advice of a finding that is not kOk.
void advise(Finding* finding, const std::string& advice);

}  // namespace slim_init::evaluation
