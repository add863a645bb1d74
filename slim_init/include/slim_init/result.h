// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The result of an initializer: a status with its evidence, and the states.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "slim_init/types.h"

namespace slim_init {

/// The status of one window. The comments name the fields of InitResult that are valid.
enum class InitStatus {
  kSuccess,  ///< everything; every enforced gate passed

  // Wait: the data do not determine the estimate yet. What is observable is returned.
  kTooFewKeyframes,      ///< nothing
  kTooFewTracks,         ///< gyro_bias, where the points sufficed for it
  kStationary,           ///< gravity_w, gravity_b0 and gyro_bias
  kTooLittleExcitation,  ///< estimate present, its scale is not reliable
  kPureRotation,         ///< gyro_bias

  // Refused: an estimate failed a check. The estimate is present for diagnosis.
  kDegenerateAlignment,
  kInconsistentResiduals,
  kScaleTooUncertain,

  // Errors.
  kInvalidInput,      ///< nothing; `message` names the offending field
  kNumericalFailure,  ///< nothing

  /// Wait; a provisional estimate for hosts without a better prior: everything as with kSuccess,
  /// but the scale may still be off by half. `covariance` says how well velocity, attitude and
  /// biases are known; a host that takes it as a prior can start with it.
  kProvisional,

  /// Wait: a search that the data need was skipped or ended (WorkLimits); `message` says which.
  /// An estimate may be present for diagnosis.
  kTimeLimit,
};

/// Stable lower-case name, used in files and messages: "success", "too_few_keyframes", ...
const char* toString(InitStatus status);

/// True for the statuses that more data may cure (kTooFewKeyframes .. kPureRotation,
/// kProvisional, kTimeLimit).
bool isWait(InitStatus status);

/// For consoles: `message` with "; " and what a user can do about `status`
/// (docs/does_not_initialize.md); `message` alone if there is nothing to do, as for a success.
std::string withRemedy(const std::string& message, InitStatus status);

/// The gates (docs/derivation.md, 6).
enum class GateName {
  kParallax,           ///< track motion without rotation
  kExcitation,         ///< deviation of the specific force from its mean
  kExtrinsicRotation,  ///< certain error of an extrinsic rotation that was known
  kExtrinsicSigma,     ///< standard deviation of one that was unknown
  kTimeOffset,         ///< certain error of td
  kLinkage,            ///< eigenvalue ratio of the translation system
  kScalePositive,
  kAlignmentResidual,
  kChi2,          ///< of the images
  kInertialChi2,  ///< of the IMU
  kInlierFraction,
  kMeanAcceleration,
  kPointSpread,
  kOtherScale,  ///< cost of another scale
  kScaleSigma,
  kVelocitySigma,  ///< of the newest keyframe (provisional estimates)
  kTiltSigma,      ///< the same, of all estimates
  kAgreement,      ///< with earlier estimates (ConsistencyCheck)
  kOther,          ///< of a method from elsewhere: GateValue::explanation says what
};

/// Stable lower-case name, used in files and messages: "parallax", "excitation", ...
const char* toString(GateName name);

/// One check: a measured number against its threshold.
struct GateValue {
  GateName name = GateName::kOther;
  std::string explanation;          ///< what was measured, as the subject of a message
  std::string unit;                 ///< "" where dimensionless
  double value = kNotComputed;      ///< measured
  double threshold = kNotComputed;  ///< bound from GateOptions
  bool upper_bound = true;          ///< passes when value <= threshold; else value >= threshold
  bool passed = false;              ///< a value that is not finite never passes
  bool enforced = false;            ///< false: reported only, does not change the status
  /// Where gates are enforced and this one is not: why. Empty otherwise.
  std::string exception;
  InitStatus status_if_failed = InitStatus::kSuccess;
};

/// Wall-clock time of one stage. The only field of InitResult that differs between equal inputs.
struct StageTime {
  std::string name;
  double ms = 0.0;
};

/// Amount of data behind an estimate.
struct SolveCounts {
  int keyframes = 0;
  int point_tracks = 0;  ///< tracks seen in >= 2 keyframes
  int line_tracks = 0;   ///< tracks seen in >= 2 keyframes
  int line_observations = 0;
};

/// The measured velocities behind an estimate.
struct SpeedUse {
  int keyframes = 0;         ///< with a speed
  int missing = 0;           ///< keyframes without one although some were given: gaps between them
  int contradicted = 0;      ///< of `keyframes`: did not agree with the motion, had little weight
  double scale_error = 0.0;  ///< relative error that the measurements have in common, estimated
};

/// The calibration that a window has measured, together with what was known before.
struct CalibrationEstimate {
  Eigen::Matrix3d R_b_c = Eigen::Matrix3d::Identity();  ///< camera to body rotation
  Eigen::Vector3d t_b_c = Eigen::Vector3d::Zero();      ///< camera centre in b [m]
  double td = 0.0;                                      ///< t_imu = stamp + td [s]
  double readout_s = 0.0;                               ///< Calibration::readout_s [s]
  /// Of the error state [rotation on the right of R_b_c (3) [rad], t_b_c (3) [m], td [s],
  /// readout_s [s]]. A part that is held as exact (CalibrationSigmas) has none.
  Eigen::Matrix<double, 8, 8> covariance = Eigen::Matrix<double, 8, 8>::Zero();

  /// Root of the largest variance of the rotation over all axes [deg].
  double rotationSigmaDeg() const;
  double tdSigma() const;       ///< [s]
  double readoutSigma() const;  ///< [s]
};

/// A calibration estimate, or none: std::optional for hosts that compile this header as C++14.
class OptionalCalibration {
 public:
  OptionalCalibration() = default;
  OptionalCalibration(const CalibrationEstimate& value)
      : present_(true), value_(value) {}  // NOLINT

  bool has_value() const { return present_; }
  explicit operator bool() const { return present_; }
  /// Present ones only.
  const CalibrationEstimate& operator*() const { return value_; }
  const CalibrationEstimate* operator->() const { return &value_; }
  CalibrationEstimate* operator->() { return &value_; }
  /// Makes it present, with the values of a fresh estimate.
  CalibrationEstimate& emplace() {
    *this = OptionalCalibration(CalibrationEstimate());
    return value_;
  }

 private:
  bool present_ = false;
  CalibrationEstimate value_;
};

/// The result of a WindowSolver. World frame w: z up (gravity_w = (0, 0, -g)), origin at the first
/// keyframe's body, and the first body's x axis has zero yaw.
struct InitResult {
  InitStatus status = InitStatus::kInvalidInput;
  /// For a person: the measured value and the threshold that decided.
  std::string message = "solve() was not called";

  /// One per keyframe of the window, or empty. Keyframes that the IMU does not cover after the
  /// correction of td are discarded; NavState::t says which are there.
  std::vector<NavState> states;
  Eigen::Vector3d gravity_w = Eigen::Vector3d::Constant(kNotComputed);   ///< [m/s^2]
  Eigen::Vector3d gravity_b0 = Eigen::Vector3d::Constant(kNotComputed);  ///< in first body [m/s^2]
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Constant(kNotComputed);   ///< [rad/s]
  /// [m/s^2]; zero where the method takes it as zero (drt-l, slim-paper).
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Constant(kNotComputed);

  /// Metric scale of the camera trajectory: metres per unit of an up-to-scale trajectory in which
  /// consecutive keyframe camera centres are one unit apart on average. So it is the mean baseline
  /// between consecutive keyframes [m]: an up-to-scale reconstruction of the same keyframes with
  /// mean baseline d becomes metric when multiplied by scale / d. Present with `states`, whatever
  /// the method. Negative where a refused estimate has mirrored the trajectory.
  double scale = kNotComputed;
  /// Standard deviation of `scale` divided by it (0.05: 5 %), or NaN where the method has none. It
  /// does not depend on the choice of the unit.
  double scale_sigma = kNotComputed;

  /// The calibration with which the states were estimated, by methods that estimate it (slim). The
  /// states are those of the body at stamp + td of this estimate (NavState::t).
  OptionalCalibration calibration;

  /// Noise of the point tracks of the window, per axis [px].
  struct TrackNoise {
    double measured_px = kNotComputed;  ///< by what pairs of views say of each other (slim)
    double assumed_px = kNotComputed;   ///< what the checks compare with: Calibration::sigma_px, or
                                        ///< the measured one within its bounds
  } track_noise;

  /// Measured velocities (IInitializer::addSpeed()); without any, all zero.
  SpeedUse speeds;

  /// Warnings beside a valid estimate, one message each: a calibration that is
  /// outside its standard deviations, with value, sigma and key; point tracks that are
  /// static in the image of a turning camera, with their number.
  std::vector<std::string> warnings;

  /// Parts of a StatePrior that the data of the window contradict, so that they were not used:
  /// "velocity", "gravity", "gyro_bias", "accel_bias".
  std::vector<std::string> prior_dropped;

  /// The states are in the odometry frame of Priors::healthy: of a recovery.
  bool frame_continued = false;

  /// The body stood still from here to the first keyframe [s, IMU clock]: a start from rest, whose
  /// world has its origin and heading where the body stood. NaN: no such start.
  double at_rest_since = kNotComputed;

  /// Covariance of the error state [theta, p, v] per keyframe followed by [b_g, b_a]; theta on the
  /// right of R_w_b. Empty where the method does not provide it (drt-l, slim-paper).
  Eigen::MatrixXd covariance;

  std::vector<GateValue> gates;
  std::vector<StageTime> stages;
  SolveCounts counts;

  bool success() const { return status == InitStatus::kSuccess; }
  bool provisional() const { return status == InitStatus::kProvisional; }
  bool hasEstimate() const { return !states.empty(); }

  /// Covariance of [theta, p, v, b_g, b_a] of one keyframe, as in `covariance`, symmetric. NaN
  /// where there is no such state or no covariance.
  Eigen::Matrix<double, 15, 15> stateCovariance(std::size_t keyframe) const;

  /// Returns an empty string where the status is neither kSuccess nor kProvisional, or where there
  /// are finite states and gravity, a covariance if it is kProvisional, and every enforced gate
  /// passed; else a message saying what contradicts the status.
  /// makeInitializer() holds every solver to it, the host adapter every initializer.
  std::string validate() const;
};

}  // namespace slim_init
