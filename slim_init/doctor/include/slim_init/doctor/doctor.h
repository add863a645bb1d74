// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Why does an estimator not initialize on a recording? Checks of messages, units, calibration,
// images and motion, each with a measured value and a bound (docs/doctor.md).
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "slim_init/evaluation/recorded.h"
#include "slim_init/host_health/calibration_lines.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
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

/// From good to bad.
enum class Severity {
  kOk,          ///< inside the bound
  kNote,        ///< no fault, but worth knowing
  kNotChecked,  ///< the data do not suffice; the advice says what would
  kWarning,     ///< works worse, or not always
  kError,       ///< will not work
};

/// Stable lower-case name: "ok", "note", "not_checked", "warning", "error".
const char* toString(Severity severity);

/// What a check found.
struct Finding {
  std::string check;  ///< stable name: "imu_rate"
  Severity severity = Severity::kOk;
  double value = kNotComputed;  ///< as measured; NaN where nothing could be
  double min = kNotComputed;    ///< bounds that the value has to keep; NaN: none on this side
  double max = kNotComputed;
  std::string unit;
  std::string message = {};  ///< what was found, with the measured value
  std::string advice = {};   ///< what to do; empty where there is nothing to do
};

/// One image, reduced to numbers.
struct ImageFacts {
  double t = 0.0;                 ///< stamp [s], camera clock
  double p99 = kNotComputed;      ///< 99 % quantile of the grey levels, [0, 255]; NaN: unreadable
  double saturated = 0.0;         ///< fraction of pixels at 250 or more
  double blur_px = kNotComputed;  ///< width of the sharpest edges as sigma [px]; NaN: no edges
  bool repeats = false;           ///< equal to the previous image in every pixel
  bool right_size = true;         ///< the configured one
};

/// Input of the doctor: the calibration as configured, which is checked, and the data. Times count
/// from any common zero; streams ascend in time.
struct DoctorData : host_health::FileCalibration {
  std::string name;
  std::vector<ImuSample> imu;
  Disorder imu_disorder;             ///< of the whole recording, as image_disorder
  std::size_t imu_beyond_limit = 0;  ///< samples of the recording that are not in `imu`
  std::vector<ImageFacts> images;
  Disorder image_disorder;
  std::size_t images_beyond_limit = 0;
  std::vector<FrameObservation> frames;  ///< tracked without the gyro
  bool lines_enabled = true;
};

/// What `slim` says about the windows of a recording, cut one after the other.
struct WindowEstimates {
  int windows = 0;
  int accepted = 0;                             ///< with the calibration as configured
  int refused = 0;                              ///< neither accepted nor for want of motion
  std::map<std::string, int> statuses;          ///< windows by name of their status
  std::map<std::string, std::string> messages;  ///< first message by status, without success
  int with_warnings = 0;                        ///< accepted ones with InitResult::warnings
  std::string warning;                          ///< the first of these
  /// What all windows together say about the calibration, solved with wide priors; its sigmas are
  /// without the floors of DoctorOptions. Absent with fewer than three windows.
  OptionalCalibration calibration;
  /// Noise of the IMU measured in its samples, and the one that `slim` then assumes: medians over
  /// the windows.
  ImuNoise measured_noise = {kNotComputed, kNotComputed};
  ImuNoise assumed_noise = {kNotComputed, kNotComputed};
  /// The same of the point tracks (InitResult::TrackNoise) [px].
  InitResult::TrackNoise track_noise;
  double excitation = kNotComputed;  ///< GateName::kExcitation, median over the windows [m/s^2]
};

/// Bounds. A finding beyond `warn` is a warning, beyond `fail` an error.
struct DoctorOptions {
  /// A value beyond `warn` is a warning, of `fail` an error.
  struct Bound {
    double warn = 0.0;
    double fail = 0.0;
  };
  Bound disorder = {0.0, 0.01};     ///< fraction of messages repeated, out of order or unreadable
  Bound imu_rate = {90.0, 50.0};    ///< [Hz] at least; 100 Hz IMUs run a little slow
  Bound imu_lost = {0.005, 0.05};   ///< fraction of samples that are missing
  double max_imu_gap_s = 0.05;      ///< no window is cut across a longer step
  double max_imu_jitter = 0.3;      ///< 90 % quantile of the steps' deviation, in periods
  Bound image_rate = {9.0, 4.0};    ///< [Hz] at least; the host publishes features at 10 Hz
  Bound images_lost = {0.02, 0.2};  ///< share
  Bound images_outside_imu = {0.1, 0.9};  ///< share; nearly all of them: two clocks
  Bound gravity = {0.04, 0.15};           ///< |measured / configured - 1| of the specific force
  Bound gyro_still = {0.2, 1.0};          ///< [rad/s] mean rate at rest; MEMS gyros are below 0.1
  double max_gyro_rate = 35.0;            ///< [rad/s]; MEMS gyros end at 2000 deg/s
  Bound gyro_scale = {0.05, 0.2};  ///< |gyro over camera - 1|; so is an error of the focal length
  double min_correlation = 0.8;    ///< of the rates of camera and gyro; 0.97 and more where right
  double mirrored_margin = 0.02;   ///< a mirrored gyro has to fit better by this
  /// To the configured calibration. `slim` estimates it, so that a difference costs accuracy and
  /// time; an error is what is beyond the range in which it does (GateOptions).
  Bound time_offset_s = {0.006, GateOptions().max_td_error_s};
  Bound extrinsic_deg = {1.0, GateOptions().max_extrinsic_error_deg};
  double max_translation_m = 0.05;  ///< two seconds of motion know it to a centimetre or two
  double significance = 4.0;        ///< a difference counts from so many sigmas on
  /// Standard deviations beyond the scatter of windows or pairs: lens model, errors of the IMU.
  double extrinsic_floor_deg = 0.2;
  double translation_floor_m = 0.01;
  /// Fraction of the windows that `slim` refuses as configured; one window beside three or more
  /// that it accepts does not count.
  Bound refused = {0.1, 0.5};
  /// Ratio of the measured noise of the IMU to the data sheet's, or its inverse: a note.
  double noise_ratio = 10.0;
  Bound epipolar_px = {1.0, 3.0};  ///< median scale of points about their epipolar lines [px]
  Bound black = {0.01, 0.5};       ///< fraction of images without light
  double black_level = 16.0;       ///< grey level that 1 % of the pixels of an image must exceed
  Bound saturated = {0.1, 0.6};    ///< fraction of images with more than half of their pixels white
  Bound blurred = {0.3, 0.9};      ///< fraction of images whose sharpest edges are wider than:
  double blur_px = 3.0;            ///< sigma of an edge [px]
  Bound repeated_images = {0.02, 0.5};  ///< fraction of images equal to the one before
  Bound points = {40.0, 15.0};          ///< median in an image, at least
  Bound survival = {0.7, 0.4};          ///< median fraction of points found again in the next image
  InitializerOptions initializer;       ///< as configured
};

/// All findings, in the order of the checks.
struct DoctorReport {
  std::string name;
  std::vector<Finding> findings;
  RotationAlignment alignment;
  WindowEstimates answers;
  std::string lines;  ///< calibrationLines() of what was found to be off, for the file

  Severity worst() const;
  /// 0: nothing worse than kNotChecked; 1: warnings; 2: errors.
  int exitCode() const;
};

/// Runs every check. Pure: equal data give an equal report.
DoctorReport examine(const DoctorData& data, const DoctorOptions& options);

/// The report as a table: findings with their values, message and advice. At most 100 columns
/// unless a word is longer. `color`: ANSI colours.
std::string doctorText(const DoctorReport& report, bool color);

/// The report as JSON (docs/doctor.md, "JSON").
std::string doctorJson(const DoctorReport& report);

}  // namespace slim_init::evaluation
