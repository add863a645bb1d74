// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The parameters of `slim` and of what all methods share. Configuration keys are the field names:
// InertialOptions::accel_bias_prior is `inertial.accel_bias_prior`. The comment of a field says
// what it is and in which unit. Its bounds, the reason of its default, and whether it is meant for
// every user stand in one table (src/data/options.cc), from which config/*.yaml is made.
#pragma once

#include <string>

#include "slim_init/types.h"

namespace slim_init {

/// With three keyframes the alignment has as many rows as unknowns; four are the minimum for a
/// check.
inline constexpr int kMinKeyframes = 4;

/// KeyframeWindow: which frames become keyframes and what is kept.
struct WindowOptions {
  int keyframes = 15;            ///< most keyframes of a window
  int min_keyframes = 5;         ///< minimum number of keyframes of a solve
  double min_interval_s = 0.09;  ///< minimum time between keyframes [s]
  /// A window that grows past its keyframes at min_interval_s has them spread over its length, up
  /// to this; 0: it does not grow past them.
  double max_span_s = 3.0;       ///< longest time from the first to the last keyframe [s]
  double max_frame_gap_s = 1.0;  ///< longest time between frames of one window [s]
  double max_imu_gap_s = 0.05;   ///< longest time between IMU samples of one window [s]
  double buffer_s = 10.0;        ///< data kept [s]

  /// Time that a full window spans [s]: max_span_s, or all keyframes at min_interval_s.
  double fullSpan() const;

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// The IMU as `slim` takes it in every stage: gyroscope bias, metric starts and refinement.
struct InertialOptions {
  double accel_noise_factor = 0.0;  ///< on ImuNoise::accel_density; 0: from the samples
  double gyro_noise_factor = 0.0;   ///< on ImuNoise::gyro_density; 0: from the samples
  double accel_bias_prior = 0.1;    ///< standard deviation of b_a before any data [m/s^2]
  double gyro_bias_prior = 0.2;     ///< standard deviation of b_g before any data [rad/s]
};

/// Dominant vanishing point of a keyframe and its track (paper IV-B-1, IV-B-2).
struct VanishingPointOptions {
  double vote_threshold_deg = 3.0;    ///< a line votes for directions this close [deg]
  double inlier_threshold_deg = 1.0;  ///< a line this close is an inlier; t_in [deg]
  int min_inliers = 8;                ///< minimum number of lines of a vanishing point
  double match_threshold_deg = 6.0;   ///< predicted to observed direction [deg]
};

/// Structureless visual-inertial refinement of `slim`.
struct RefinementOptions {
  bool use_lines = true;            ///< line residuals
  bool estimate_accel_bias = true;  ///< off: b_a is held at what is known of it, or zero
  int max_iterations = 8;           ///< Levenberg-Marquardt steps of one minimisation, refused too
  double tolerance = 0.1;           ///< squared length of the last step [sigma^2]
  double cauchy_sigmas = 3.0;       ///< Cauchy scale of a residual [sigma]
  double min_sigma_px = 0.2;        ///< floor of the estimated noise of a point [px]
  double reject_sigmas = 3.5;       ///< largest residual kept [sigma]
  double suspicious_chi2 = 1.0;     ///< chi-square per degree of freedom to search again from
};

/// The switches of `slim`, one per ingredient. Those of the refinement are in
/// RefinementOptions.
struct SlimOptions {
  bool vanishing_points = true;  ///< in the gyroscope bias
  bool prune_tracks = true;      ///< take out tracks that contradict the bias or stand still
  bool prune_lines = true;       ///< cut line tracks where they contradict the start
  bool refine = true;            ///< off: the start is the estimate
  bool start_from_rest = true;   ///< the first motion after a rest is solved with that as a prior
};

/// Whose gates decide.
enum class GateMode {
  kOwn,  ///< as the method was published: on for slim, off for methods that have none
  kOn,   ///< enforced for every method
  kOff,  ///< measured and reported, never enforced
};

/// The name in a configuration file: "own", "on", "off".
const char* toString(GateMode mode);

/// Thresholds of the gates.
struct GateOptions {
  GateMode mode = GateMode::kOwn;  ///< whose gates decide
  double min_parallax_px = 3.0;    ///< median motion of tracks over 9 keyframes or more [px]
  double min_excitation = 0.10;    ///< rms deviation of the specific force [m/s^2]
  double max_scale_sigma = 0.075;  ///< relative standard deviation of the scale, full window
  double max_scale_sigma_expanding = 0.05;   ///< the same of a window that is not full yet
  double max_scale_sigma_fixed_size = 0.10;  ///< the same of windows of one number of keyframes
  double max_chi2 = 1.5;                     ///< visual chi-square per degree of freedom
  double max_inertial_chi2 = 1.0;            ///< inertial chi-square per residual
  double min_inlier_fraction = 0.6;          ///< fraction of the point observations left
  double max_extrinsic_error_deg = 15.0;     ///< certain error of the extrinsic rotation [deg]
  double max_td_error_s = 0.08;              ///< certain error of the time offset [s]
  double max_extrinsic_sigma_deg = 0.5;      ///< of an extrinsic rotation that was unknown [deg]
};

/// Estimates before the scale is known (InitStatus::kProvisional), for hosts that take a prior.
struct ProvisionalOptions {
  bool enabled = false;             ///< offer one where there is no success
  double max_velocity_sigma = 0.4;  ///< of the newest velocity, along its worst axis [m/s]
  double max_tilt_sigma_deg = 3.0;  ///< of the newest attitude against gravity [deg]
  double max_scale_sigma = 0.4;     ///< of the logarithm of the scale
  double speed_prior = 2.0;         ///< standard deviation of a velocity before any data [m/s]
};

/// How much one solve may compute: a call of IInitializer::initialize() or recover(), with all that
/// belongs to it.
struct WorkLimits {
  double max_solve_ms = 50.0;  ///< processor time of one solve [ms]; 0: no limit
  double work_per_ms = 0.0;    ///< units of work in a millisecond (WorkBudget); 0: of a desktop
};

/// All options of an initializer.
struct InitializerOptions {
  ImuLimits imu;                          ///< of the IMU stream
  WindowOptions window;                   ///< keyframes
  InertialOptions inertial;               ///< noise and priors of the IMU
  VanishingPointOptions vanishing_point;  ///< vanishing points
  RefinementOptions refinement;           ///< refinement of `slim`
  SlimOptions slim;                       ///< switches of `slim`
  GateOptions gates;                      ///< gates
  ProvisionalOptions provisional;         ///< estimates before the scale is known
  WorkLimits limits;                      ///< how long one solve may take

  /// Returns an empty string, or the first message of a nested validate(), prefixed with the
  /// section ("window.keyframes is 1, must be in [4, 50]").
  std::string validate() const;
};

}  // namespace slim_init
