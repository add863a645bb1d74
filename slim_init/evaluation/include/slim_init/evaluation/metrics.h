// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Errors of one estimate against the ground truth. Formulas: docs/evaluation.md.
#pragma once

#include <string>
#include <vector>

#include "slim_init/init_window.h"
#include "slim_init/result.h"
#include "slim_init/types.h"

namespace slim_init::evaluation {

/// target = s * R * source + t.
struct Similarity {
  double s = 1.0;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};

/// Least squares similarity from `source` to `target` (Umeyama 1991). Works for collinear points,
/// where R is one of many and s is still unique. Returns an empty string, or a sentence where s
/// does not exist: sizes differ, fewer than two points, a coordinate that is not finite, all source
/// points in one place.
std::string alignSimilarity(const std::vector<Eigen::Vector3d>& source,
                            const std::vector<Eigen::Vector3d>& target, Similarity* similarity);

/// target = R_z(yaw) source + t: the alignment of two worlds that share gravity and scale.
struct HeadingAlignment {
  double yaw = 0.0;  ///< [rad]
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  Eigen::Vector3d apply(const Eigen::Vector3d& p) const;
};

/// Least squares over positions; equal sizes, at least one. Yaw is zero where the points stand on
/// one vertical.
HeadingAlignment alignHeading(const std::vector<Eigen::Vector3d>& source,
                              const std::vector<Eigen::Vector3d>& target);

/// |s - 1| below this is a successful initialization (paper V-B, He et al. 2023).
inline constexpr double kSuccessScaleError = 0.5;

/// Errors of one window. Either all fields are finite (gyro_bias_err_pct excepted, which does not
/// exist for a zero true bias), or `failure` says why none is. An estimate without states, of a
/// window that stands still for example, has errors of gravity and gyro bias, if it knows them.
struct WindowMetrics {
  /// s of ground truth = s R estimate + t; negative where the estimate runs the other way, seen
  /// from the first body (R would hide that on a path that is nearly planar).
  double scale = kNotComputed;
  double scale_error = kNotComputed;        ///< |s - 1|
  double pose_rmse = kNotComputed;          ///< positions after the Sim(3) alignment [m]
  double velocity_rmse = kNotComputed;      ///< difference of speeds, no alignment [m/s]
  double velocity_vec_rmse = kNotComputed;  ///< velocity vectors in the first body frame [m/s]
  double gravity_error_deg = kNotComputed;  ///< angle in the first body frame [deg]
  double gyro_bias_err_pct = kNotComputed;  ///< 100 | |b| - |b_true| | / |b_true|
  double gyro_bias_vec_err = kNotComputed;  ///< |b - b_true| [rad/s]
  std::string failure;                      ///< empty when computed

  bool computed() const { return failure.empty(); }
  bool success() const { return computed() && scale_error < kSuccessScaleError; }
};

/// Compares an estimate with the ground truth at the times of its states, or of the keyframes of a
/// window without; the true gyro bias is the mean over them. A value that is not finite on either
/// side, or ground truth of another time than its state, makes the whole window fail.
WindowMetrics evaluateWindow(const InitResult& result, const std::vector<NavState>& truth);

/// One calibration minus another.
struct CalibrationDifference {
  double td_s = kNotComputed;
  double rotation_deg = kNotComputed;  ///< angle between the two R_b_c
  double readout_s = kNotComputed;
};

CalibrationDifference calibrationDifference(const Calibration& calibration,
                                            const Calibration& truth);

/// Errors of a calibration that a method has estimated, and its own opinion on them. NaN where it
/// estimates none, a standard deviation also where it holds the value as exact.
struct CalibrationErrors : CalibrationDifference {  // estimate minus ground truth
  double td_sigma_s = kNotComputed;                 ///< standard deviation stated
  double rotation_sigma_deg = kNotComputed;         ///< CalibrationEstimate::rotationSigmaDeg()
  /// Error of the rotation over its standard deviation, per axis: sqrt(e^T P^-1 e / 3).
  double rotation_over_sigma = kNotComputed;
  double readout_sigma_s = kNotComputed;

  bool computed() const { return td_s == td_s; }
  double tdOverSigma() const { return td_s / td_sigma_s; }
};

CalibrationErrors evaluateCalibration(const CalibrationEstimate& estimate,
                                      const Calibration& truth);

/// The excitation gate of DRT's release (He et al. 2023), applied to a window.
struct Excitation {
  /// | |mean of dv_ij / dt_ij| - g | / g over consecutive keyframes.
  double mean_deviation = kNotComputed;
  /// Pairs with | |dv_ij / dt_ij| - g | / g < 5e-3.
  int quiet_pairs = 0;
  bool excited = false;  ///< mean_deviation > 5e-3 and quiet_pairs <= 1
};

/// dv_ij is the specific force integrated in the frame of body i, gyro and accelerometer bias taken
/// as zero; dt_ij the time between the keyframes.
Excitation measureExcitation(const InitWindow& window);

}  // namespace slim_init::evaluation
