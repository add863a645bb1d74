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

/// The certain part of an error of the calibration is the estimate less this many sigma, and beyond
/// as many of prior and estimate together there is a warning.
inline constexpr double kCertainSigmas = 2.5;
/// Least fraction of the observations kept, in place of GateOptions::min_inlier_fraction, by an
/// answer of an expanding window that contradicts the calibration: with few outliers nine tenths
/// are, with a moving object three quarters.
inline constexpr double kMostInliers = 0.85;
/// Without translation: less rotation over the window is stationary, more is pure rotation [deg].
inline constexpr double kMinRotationDeg = 2.0;
/// Without translation: largest deviation of the specific force of a window at rest; above it the
/// vehicle accelerates and the scene is too far away [m/s^2].
inline constexpr double kMaxRestDeviation = 0.5;
/// Least rms angle over which the points of an image are spread [deg].
inline constexpr double kMinPointSpreadDeg = 2.0;
/// Largest change of the velocity over the window by its length [m/s^2], where the specific force
/// deviates less than that. A quiet motion far from everything also fits a fall along a tilted
/// gravity, with 11; recorded flights have up to 4.
inline constexpr double kMaxMeanAcceleration = 8.0;
/// Least cost of any other minimum above that of the answer [sigma^2]: four standard deviations. Of
/// right answers one in five hundred has another minimum as low, and 40 would refuse no more.
inline constexpr double kMinOtherScaleRise = 16.0;

struct Posterior;
struct RefinedWindow;
struct ScaleProfile;

/// A value with its bound; one that is not known does not pass.
GateValue atMost(double value, double threshold);
GateValue atLeast(double value, double threshold);
/// The same with its name, what was measured, and the status if it fails.
GateValue makeGate(GateName name, const std::string& explanation, const char* unit, GateValue gate,
                   InitStatus status_if_failed);

/// What the motion in a window offers, before any alignment.
struct MotionMeasures {
  double parallax_px = kNotComputed;      ///< see measureTracks()
  double least_motion_px = kNotComputed;  ///< see leastMotionPx()
  double track_length = 0.0;              ///< median number of keyframes that see a point
  double rotation_deg = kNotComputed;     ///< see maxRotationDeg()
  Eigen::Vector3d mean_force =
      Eigen::Vector3d::Zero();  ///< specific, over the window, in b0 [m/s^2]
  /// Rms over the keyframe pairs of the deviation of their mean specific force from that [m/s^2].
  /// Zero at constant velocity, where the scale is not observable.
  double excitation = kNotComputed;
  bool has_speeds = false;  ///< measured velocities give the scale without excitation too
};

/// Medians over the tracks: their lengths, and the largest rotation-compensated angle between the
/// first observation and any other, in pixels at the image centre. Without tracks `motion` is left
/// alone. `R_c0_ck`: camera k to first camera.
void measureTracks(const InitWindow& window, const std::vector<Eigen::Matrix3d>& R_c0_ck,
                   MotionMeasures* motion);

/// The motion that a bias of the gyroscope leaves the tracks [px]: without the constant rate, up to
/// `rate_sigma` about each axis [rad/s], that moves their median from first to last observation.
/// Before a far scene a bias that lets it move makes an object stand that moves; to epipolar
/// residuals it is as good as the right one.
double leastMotionPx(const InitWindow& window, double rate_sigma,
                     std::vector<Eigen::Matrix3d> R_c0_ck);

/// Largest rotation of any keyframe against the first [deg].
double maxRotationDeg(const std::vector<Eigen::Matrix3d>& R_b0_bk);

/// The forces of MotionMeasures.
void measureForce(const std::vector<Preintegration>& pre,
                  const std::vector<Eigen::Matrix3d>& R_b0_bk, MotionMeasures* motion);

/// Gates on the motion: "parallax" and "excitation". Tracks over fewer keyframes
/// average less noise and need more parallax: without translation they have a small and definite
/// shape made of noise. Tracks and IMU together classify a missing parallax: beyond kMinRotationDeg
/// a pure rotation; with a steady specific force (below kMaxRestDeviation over 0.25 s means, so
/// that a vibrating vehicle is at rest) stationary; with an unsteady one too little excitation of
/// the camera, the scene is too far. Where it could not be measured, too few tracks. Tracks that
/// move while the IMU is quiet are a slide at constant velocity and fail "excitation", which is not
/// enforced with measured velocities.
std::vector<GateValue> motionGates(const MotionMeasures& motion, const GateOptions& options);

/// Of those the gate that a provisional answer needs too.
GateValue parallaxGate(const MotionMeasures& motion, const GateOptions& options);

/// Gates on the calibration found, against the one handed in: "extrinsic_rotation"
/// ("extrinsic_sigma" where it was unknown) and "time_offset", values are the certain part of each
/// error (kCertainSigmas), explanations the estimate itself.
std::vector<GateValue> calibrationGates(const Calibration& handed_in,
                                        const CalibrationEstimate& found,
                                        const GateOptions& options);

/// A warning for every part of the calibration `found` that differs from the one handed in by more
/// than kCertainSigmas of both standard deviations: value, sigma and the key to change. Whether
/// there is one.
bool appendCalibrationWarnings(const Calibration& handed_in, const CalibrationEstimate& found,
                               InitResult* result);

/// The same for the accelerometer bias, against its prior. `result`: with states and covariance.
bool appendBiasWarning(const InertialOptions& inertial, InitResult* result);

/// Whether a window spans what is possible (ConsistencyCheck::kFullFraction).
bool isFull(const InitWindow& window, const WindowOptions& options);

/// The bounds in force for a window: `options` with max_scale_sigma replaced by
/// max_scale_sigma_expanding if the window is not full (ConsistencyCheck::kFullFraction), and by
/// max_scale_sigma_fixed_size if it is and all windows have one number of keyframes.
GateOptions gatesInForce(const GateOptions& options, const InitWindow& window,
                         const WindowOptions& window_options);

/// What a host that starts from the newest state needs: standard deviations.
struct NewestSigmas {
  double velocity = kNotComputed;  ///< in the body frame, along the worst axis [m/s]
  double tilt_deg = kNotComputed;  ///< against gravity, about the worst axis [deg]
};

/// What the refinement of `slim` says about its answer.
struct PosteriorMeasures {
  double sigma_px = kNotComputed;            ///< noise of the tracks that `chi2` is in [px]
  double chi2 = kNotComputed;                ///< RefinedWindow::chi2
  double inertial_chi2 = kNotComputed;       ///< RefinedWindow::inertial_chi2
  double inlier_fraction = kNotComputed;     ///< of all point observations of the window
  double scale_sigma = kNotComputed;         ///< relative
  double point_spread_deg = kNotComputed;    ///< rms angle of the points of a keyframe [deg]
  double scale = kNotComputed;               ///< InitResult::scale [m]
  bool profiled = true;                      ///< other scales were looked for
  double other_scale = kNotComputed;         ///< the best other one, as InitResult::scale [m]
  double other_scale_rise = kNotComputed;    ///< ScaleProfile::other_rise
  bool has_speeds = false;                   ///< most measured velocities fit the estimate
  double motion_scale_sigma = kNotComputed;  ///< relative, of the scale of images and IMU alone
  /// Largest difference of a velocity from their mean, divided by that.
  double velocity_change = kNotComputed;
  double mean_acceleration = kNotComputed;  ///< |v_last - v_first| by the time between [m/s^2]
  NewestSigmas newest;
};

/// Gathers them: `window` as handed in, `tracks` what the pruning left of it, `profile` null where
/// none was asked for, `scale` as InitResult::scale.
PosteriorMeasures measurePosterior(const InitWindow& window, const InitWindow& tracks,
                                   const RefinedWindow& refined, const Posterior& posterior,
                                   const ScaleProfile* profile, double scale);

/// Relative standard deviation of the scale of images and IMU: that of the posterior, or of the
/// interval of the profile, which knows no measured velocities, where that is wider. `profile` may
/// be null.
double scaleSigma(const Posterior& posterior, const ScaleProfile* profile);

/// The same of an answer that may rest on measured velocities, under the bounds in force.
/// Velocities count where images and IMU do not show the scale, so that nothing can check them, and
/// in a window that is `full`. In a motion that begins to show the scale the
/// check comes first: an answer waits until images and IMU alone reach the bound.
double scaleSigma(const PosteriorMeasures& measures, double posterior_sigma, bool full,
                  double max_scale_sigma);

/// Gates on a refined answer: "chi2", "inertial_chi2", "inlier_fraction", "mean_acceleration"
/// (inconsistent residuals), "point_spread" (too few tracks), "tilt_sigma" (scale too uncertain),
/// "other_scale" and "scale_sigma" (scale too uncertain; where the motion fails the excitation gate
/// as well, too little excitation). "other_scale" names both scales; without a profile it is left
/// out. With measured velocities it compares the scale with that of images and IMU alone
/// (inconsistent residuals).
std::vector<GateValue> posteriorGates(const PosteriorMeasures& measures,
                                      const MotionMeasures& motion, const GateOptions& options,
                                      const ProvisionalOptions& newest);

/// Gates on a provisional answer: those of posteriorGates() with the bound on the scale of
/// `bounds` (infinite: without that gate), and "velocity_sigma" [m/s] (scale too uncertain).
std::vector<GateValue> provisionalGates(const PosteriorMeasures& measures, MotionMeasures motion,
                                        GateOptions options, const ProvisionalOptions& bounds);

/// "EXPLANATION VALUE UNIT (limit BOUND)", "(minimum BOUND)" for a lower bound.
std::string describe(const GateValue& gate);

/// Enforces the gates of `slim` unless `mode` is kOff: all but those with an exception.
void enforceGates(GateMode mode, InitResult* result);

/// Sets status and message of `result` from its gates: the first enforced gate that failed decides;
/// `enforce_all` enforces every one. Without such a failure the status is kSuccess, and the message
/// names the first failure that was not enforced.
void decide(bool enforce_all, InitResult* result);

}  // namespace slim_init
