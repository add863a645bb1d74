// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Gates: from measured number and threshold to a verdict. Message, test and decision use the same
// constant.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "imu/preintegration.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"

namespace slim_init {

/// What the motion in a window offers, before any alignment.
struct MotionMeasures {
  double parallax_px = kNotComputed;   ///< see medianParallaxPx()
  double rotation_deg = kNotComputed;  ///< see maxRotationDeg()
  double excitation = kNotComputed;    ///< see forceDeviation() [m/s^2]
};

/// Median over the tracks of the largest rotation-compensated angle between the first sighting and
/// any other, in pixels at the image centre. NaN without tracks. `R_c0_ck`: camera k to first
/// camera.
double medianParallaxPx(const InitWindow& window, const std::vector<Eigen::Matrix3d>& R_c0_ck);

/// Largest rotation of any keyframe against the first [deg].
double maxRotationDeg(const std::vector<Eigen::Matrix3d>& R_b0_bk);

/// Rms over the keyframe pairs of the deviation of the mean specific force, rotated to b0, from its
/// mean over the window [m/s^2]. Zero at constant velocity, where the scale is not observable.
double forceDeviation(const std::vector<Preintegration>& pre,
                      const std::vector<Eigen::Matrix3d>& R_b0_bk);

/// Gates on the motion: "parallax" (failing as stationary or, beyond min_rotation_deg, as pure
/// rotation; as too few tracks where it could not be measured) and "excitation".
std::vector<GateValue> motionGates(const MotionMeasures& motion, const GateOptions& options);

/// Gates on a loosely-coupled answer: "linkage" and "scale_positive" (degenerate alignment),
/// "alignment_residual" (inconsistent residuals), "scale_sigma" (scale too uncertain).
/// "scale_positive" is enforced for every method: a scale that is not positive contradicts the
/// points being in front of the camera, so there is no answer to accept.
std::vector<GateValue> alignmentGates(double linkage, double scale, double residual_rms,
                                      double scale_sigma, const GateOptions& options);

/// One sentence: what the gate measured, what it needs.
std::string describe(const GateValue& gate);

/// Sets status and message of `result` from its gates: the first enforced gate that failed decides;
/// `enforce_all` enforces every one. Without such a failure the status is kSuccess, and the message
/// names the first failure that was not enforced.
void decide(bool enforce_all, InitResult* result);

}  // namespace slim_init
