// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Does the calibration fit the data? Rotations that the points alone measure against those of the
// gyroscope, in terms of the two errors that turn them: extrinsic rotation and time offset. And
// what keyframe pairs say about the camera itself: the noise of its tracks and an error of its
// readout time, where each pair has the rotation and the direction of travel that its own points
// see, so that neither scale nor motion, bias, extrinsic or td matter (docs/derivation.md, 6.1).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rotation/free_rotations.h"
#include "rotation/keyframe_pairs.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// Pairs of three equations for seven unknowns, with one over for a check.
inline constexpr int kMinPairs = 4;
/// The longest readout time of a camera [s]; one that is known to worse than half of it is not
/// known.
inline constexpr double kLargestReadout = 0.04;

/// Variance of Gaussian errors by their squares, not empty, gross errors left out: that of those
/// within kOutlierSigmas.
double noiseVariance(const std::vector<double>& squares);

/// Standard deviation of a bearing across its epipolar plane [rad], by noiseVariance() of the
/// residuals, with what the fit of each pair took taken back. NaN with fewer than
/// kMinNoiseResiduals. `rotations`: freeRotations() of `pairs`.
double trackNoise(const KeyframePairs& pairs, const std::vector<RotationCorrection>& rotations);

/// An error of the readout time.
struct ReadoutCheck {
  bool valid = false;
  double error_s = 0.0;  ///< true readout less that of the window's calibration [s]
  double sigma_s = 0.0;  ///< its standard deviation [s]
};

/// The readout time that makes the epipolar residuals smallest: one step from the rotations and
/// baselines of the pairs, which are eliminated. `window`: the rows are compensated at the readout
/// time of its calibration; `gyro_bias` [rad/s]; `sigma` [rad] of a bearing, for the weights. Not
/// valid where the camera does not turn, or where no rows are known.
ReadoutCheck checkReadout(const InitWindow& window, const KeyframePairs& pairs,
                          const std::vector<RotationCorrection>& rotations,
                          const Eigen::Vector3d& gyro_bias, double sigma);

/// What has to be added to the calibration to make both sensors agree, first order.
struct CalibrationCheck {
  bool valid = false;  ///< the pairs determine all unknowns
  /// True extrinsic rotation: R_b_c Exp(extrinsic_error) [rad].
  Eigen::Vector3d extrinsic_error = Eigen::Vector3d::Zero();
  double td_error_s = 0.0;  ///< true td: Calibration::td + td_error_s [s]
  /// Of [extrinsic_error, td_error_s], scaled by the scatter of the pairs. (On recorded motion the
  /// standard deviations are half as large again as the errors.)
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
};

/// With extrinsic error delta, time offset error d and gyroscope bias error b, and w the angular
/// rate in the camera at both ends, the points see R_ci_cj Exp(phi),
///   phi = (I - R_cj_ci) delta + (w_j - R_cj_ci w_i) d + dR_dbg b   (docs/derivation.md),
/// solved by robust weighted least squares over the pairs. Standard deviations are scaled by the
/// scatter of the pairs about the model where that is larger than expected. A window that turns
/// about one axis only leaves the error about that axis open: it has a large standard deviation
/// then, from a prior of 90 deg, 0.5 s and 0.5 rad/s.
CalibrationCheck checkCalibration(const InitWindow& window, const Eigen::Vector3d& gyro_bias,
                                  const std::vector<RotationCorrection>& corrections);

}  // namespace slim_init
