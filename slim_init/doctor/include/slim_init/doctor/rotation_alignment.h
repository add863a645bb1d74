// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Does the camera turn as the gyro says? Time offset, extrinsic rotation, scale and bias of a
// gyroscope against a camera, from the point tracks of a whole recording.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::evaluation {

/// Bounds of the comparison (docs/doctor.md).
namespace rotation_alignment {
constexpr int kMinPoints = 15;      ///< common points of a pair of images
constexpr int kMinPairs = 10;       ///< fewer do not determine anything
constexpr double kMinRate = 0.05;   ///< rms [rad/s]; slower rotation does not determine anything
constexpr double kMaxOffset = 0.3;  ///< offsets are searched this far from the configured one [s]
}  // namespace rotation_alignment

/// Whether there is an alignment, or why not.
enum class AlignmentStatus {
  kSolved,
  kTooFewPairs,    ///< fewer than kMinPairs with points and IMU data
  kTooLittleTurn,  ///< neither camera nor gyro turns by kMinRate
};

/// Rotation of the camera against that of the gyro, pair of images by pair. The sigmas come from
/// the scatter of the pairs.
struct RotationAlignment {
  AlignmentStatus status = AlignmentStatus::kTooFewPairs;
  int pairs = 0;
  double camera_rate = kNotComputed;  ///< rms over the pairs, their own noise taken off [rad/s]
  double gyro_rate = kNotComputed;    ///< rms over the same times about the mean [unit of gyro]
  Eigen::Vector3d gyro_mean = Eigen::Vector3d::Constant(kNotComputed);  ///< [unit of gyro]
  double residual_px = kNotComputed;    ///< median distance scale of points to epipolar lines [px]
  double flow_px_per_s = kNotComputed;  ///< median speed of points in the image [px/s]

  // kSolved only.
  double correlation = kNotComputed;           ///< of both rates about their means, [-1, 1]
  double mirrored_correlation = kNotComputed;  ///< the same with a gyro axis reversed
  double gyro_scale = kNotComputed;            ///< gyro over camera; 57.3 is a gyro in deg/s
  double gyro_scale_sigma = kNotComputed;
  double td = kNotComputed;  ///< t_imu = t_image + td [s]
  double td_sigma = kNotComputed;
  Eigen::Matrix3d R_b_c = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d R_covariance = Eigen::Matrix3d::Identity();  ///< of R_b_c Exp(.) [rad^2]
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();         ///< [rad/s], after the scale
};

/// Measures the rotation of pairs of images by their common points alone and aligns it with the
/// gyro's: correlation of the rates over all offsets, with the best rotation for each (Procrustes).
///
/// Neither td nor R_b_c of `calibration` is trusted: td is the centre of the search, R_b_c fills in
/// what the motion leaves open (turns about one axis only). `frames` and `imu` ascend in time.
RotationAlignment alignRotations(const std::vector<FrameObservation>& frames,
                                 const std::vector<ImuSample>& imu, const Calibration& calibration);

}  // namespace slim_init::evaluation
