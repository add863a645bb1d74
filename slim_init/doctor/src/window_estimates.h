// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim` on the windows of a recording: its verdicts as configured, the calibration that all
// windows together have, and the noise of the IMU as it measures it.
#pragma once

#include "slim_init/doctor/doctor.h"

namespace slim_init::evaluation {

/// Cuts windows one after the other, without overlap, and solves each of them twice: with the
/// calibration as configured, for the verdict, and with wide priors about the one that `alignment`
/// has found (the configured one where that is near, or nothing was found), for the calibration.
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

}  // namespace slim_init::evaluation
