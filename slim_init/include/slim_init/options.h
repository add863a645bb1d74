// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Every number a user may turn, with default, unit and reason. Configuration keys are the field
// names (config/README.md).
#pragma once

#include <string>

#include "slim_init/imu_limits.h"

namespace slim_init {

/// With three keyframes the alignment has as many rows as unknowns; four are the least for a check.
inline constexpr int kMinKeyframes = 4;

/// KeyframeWindow: which frames become keyframes and what is kept.
struct WindowOptions {
  int keyframes = 10;            ///< keyframes of a full window; 10 as in DRT and the paper (V-D)
  int min_keyframes = 10;        ///< a window with fewer is "too_few_keyframes"
  double min_interval_s = 0.22;  ///< [s] between keyframes; 0.22 as in DRT's release
  double max_frame_gap_s = 1.0;  ///< [s] a longer gap between frames ends the window (blackout)
  double max_imu_gap_s = 0.05;   ///< [s] a longer gap between samples ends the window
  double buffer_s = 10.0;        ///< [s] of data kept; bounds the memory

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Gyroscope bias of `slim`: noise-normalised epipolar cost over keyframe pairs 1, 2, 4 and 8
/// apart.
struct MultiGapBiasOptions {
  int max_gap = 8;              ///< largest gap used; 1 leaves consecutive pairs only (ablation)
  int min_points_per_pair = 6;  ///< pairs with fewer common tracks do not enter
  int max_iterations = 10;      ///< Levenberg-Marquardt iterations per round
  double cauchy_sigmas = 3.0;   ///< Cauchy scale of a VP residual, in standard deviations
  double vp_inflation = 4.0;    ///< on the VP covariance: clutter among the inliers is not in it
  double bias_prior = 0.2;      ///< standard deviation of the bias before any data [rad/s]
  double max_bias = 1.0;        ///< [rad/s] a larger answer is a numerical failure

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Known-rotation pruning of point tracks.
struct TrackPruningOptions {
  double threshold_sigmas = 3.5;  ///< a residual above this many standard deviations disagrees
  int min_points_per_pair = 6;    ///< pairs with fewer common tracks are not tested
  int hypotheses = 20;            ///< two-point translation directions tried per pair

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Consensus gyroscope bias of `slim`: start, pruning, multi-gap refinement.
struct RobustBiasOptions {
  MultiGapBiasOptions refinement;
  TrackPruningOptions pruning;
  /// Further starts tried, at most, when the first solution does not look clean.
  int candidates = 3;
  /// The first solution is taken as it is when this share of the sightings agrees with it.
  double clean_inlier_fraction = 0.97;
  /// .. and its mean truncated squared residual [sigma^2] is below this. Right solutions of clean
  /// windows have 0.9, one in ten 1.1; wrong minima mostly 1.2 to 2.4.
  double clean_cost = 1.15;
  double min_inlier_fraction = 0.3;  ///< less is no consensus
  /// On the calibration's gyroscope density in the covariance of the bias; real sensors vibrate.
  double gyro_noise_inflation = 3.0;

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Dominant vanishing point of a keyframe and its track (paper IV-B-1, IV-B-2).
struct VanishingPointOptions {
  /// 4: 1281 directions on the hemisphere, none further than 2.8 deg from any direction. Less than
  /// 4 needs a larger vote_threshold_deg (5.5 deg at 3).
  int icosphere_subdivisions = 4;
  double vote_threshold_deg = 3.0;  ///< a line votes for directions this close to its plane
  /// t_in of the paper: |n . d| of a line on the VP. At 2 deg a quarter of clutter among the lines
  /// doubles the squared error, at 1 deg it adds a fifth.
  double inlier_threshold_deg = 1.0;
  /// Fewer lines make no VP. Among 25 lines without any common direction four meet by chance nine
  /// times in ten, eight once in thirty.
  int min_inliers = 8;
  double match_threshold_deg = 6.0;  ///< gyro-predicted to observed direction, to keep the id
  int min_track_age = 2;             ///< A_min of the paper, in keyframes
  /// t_vp of the paper: rms of e^vp over the inliers. Lines spread evenly up to t_in have 0.58
  /// t_in, so this tells a bundle that is no VP.
  double consistency_threshold_deg = 0.5;

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Step 2, LiGT translations (Cai et al. 2021) and linear alignment.
struct AlignmentOptions {
  int min_track_length = 3;        ///< keyframes; two views say nothing about relative scale
  int min_tracks = 8;              ///< fewer tracks of that length are "too_few_tracks"
  double min_parallax_rad = 1e-4;  ///< tracks with less rotation-compensated parallax are left out
  /// Three-view rows of line tracks beside those of the points, for every method that takes LiGT.
  bool use_line_rows = false;

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Reverse alignment of `slim`.
struct ReverseAlignmentOptions {
  double accel_bias_prior = 0.1;      ///< standard deviation of b_a before any data [m/s^2]
  double min_scale = 0.02;            ///< smallest scale searched [m]
  double max_scale = 50.0;            ///< largest scale searched [m]
  int grid = 36;                      ///< points of the logarithmic grid between them
  double length_weight = 1e3;         ///< kappa, in units of the mean diagonal of the information
  double log_scale_tolerance = 1e-5;  ///< end of the search, in log(scale)

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Structureless visual-inertial refinement of `slim`.
struct RefinementOptions {
  bool use_lines = true;
  bool use_vanishing_points = true;
  bool estimate_accel_bias = true;  ///< off: b_a is held at zero (ablation)
  int max_iterations = 12;          ///< Levenberg-Marquardt steps of one minimisation
  /// A step shorter than this is the last: squared length in standard deviations of the state.
  double tolerance = 0.1;
  double cauchy_sigmas = 3.0;     ///< Cauchy scale, in standard deviations of a residual
  double accel_bias_prior = 0.1;  ///< standard deviation of b_a before any data [m/s^2]
  double gyro_bias_prior = 0.2;   ///< standard deviation of b_g before any data [rad/s]
  double vp_inflation = 4.0;      ///< on the VP covariance: clutter among the inliers is not in it
  /// Real sensors in motion are noisier than their data sheet: recorded EuRoC IMU data deviate from
  /// the truth by 7 to 12 data-sheet sigmas per 0.25 s.
  double accel_noise_factor = 10.0;
  double gyro_noise_factor = 3.0;  ///< on the gyro density, for the same reason
  /// Floor of the estimated noise of a point [px]: tracks drift together, which their scatter does
  /// not show. The front end's are 0.13 to 0.22 px off between keyframes (docs/benchmark.md).
  double min_sigma_px = 0.2;
  double reject_sigmas = 3.5;  ///< observations beyond are taken out before the second solve
  double min_reject_px = 0.5;  ///< .. but never those below this [px]
  int min_line_views = 3;      ///< two views of a line say nothing about the motion
  /// A line track is cut where it departs from one line in space, seen from the start, by more
  /// than this [standard deviations of an end point]; room for the start's own error.
  double line_agreement_sigmas = 6.0;
  /// Visual chi-square per degree of freedom above which a minimum looks wrong and is searched for
  /// again. Right ones have 0.6 to 1.1, and a search in vain costs little.
  double suspicious_chi2 = 1.0;

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// The switches of `slim`, one per ingredient; each off is a row of the ablation table. Those of
/// the refinement are in RefinementOptions, of the bias in RobustBiasOptions.
struct SlimOptions {
  bool vanishing_points = true;  ///< in the gyroscope bias and in the refinement
  bool prune_tracks = true;      ///< take out tracks that contradict the consensus bias
  bool prune_lines = true;       ///< cut line tracks where they contradict the start
  bool reverse_start = true;     ///< start from the reverse alignment
  bool tight_start = true;       ///< start from the closed-form tight alignment
  bool refine = true;            ///< off: the first start is the answer
  bool second_search = true;     ///< search for a lower minimum where the first looks wrong
  /// With fewer point tracks it is searched for in any case: one bad track among a dozen bends the
  /// minimum without showing, and the search is cheap.
  int few_tracks = 50;

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Whose gates decide.
enum class GateMode {
  kOwn,  ///< as the method was published: on for slim, off for methods that have none
  kOn,   ///< enforced for every method
  kOff,  ///< measured and reported, never enforced
};

/// Thresholds of the verdict (src/verdict).
struct GateOptions {
  GateMode mode = GateMode::kOwn;
  /// The strict profile of `slim`: max_scale_sigma at most 0.05, max_chi2 at most 1.2,
  /// min_inlier_fraction at least 0.7. Fewer windows are accepted, and those are better.
  bool strict = false;
  /// Rotation-compensated track motion over the window, median [px]; less is "no translation".
  double min_parallax_px = 3.0;
  /// Rotation over the window [deg]; less, without translation, is stationary, more is a pure
  /// rotation.
  double min_rotation_deg = 2.0;
  /// Without parallax, the same rms deviation as of min_excitation up to which the window is at
  /// rest [m/s^2]. Above it the vehicle accelerates, and the scene is too far to show it.
  double max_rest_deviation = 0.5;
  /// Rms deviation of the world-frame specific force from its mean over the window [m/s^2]; less
  /// is motion at constant velocity, in which the scale is not observable.
  double min_excitation = 0.10;
  /// Ratio of the second to the first eigenvalue of the translation system; less means that the
  /// tracks do not link the window.
  double min_linkage = 10.0;
  /// Rms residual of the velocity and position rows over the window, in m/s and m alike.
  double max_alignment_residual = 0.10;
  /// Relative standard deviation of the scale.
  double max_scale_sigma = 0.10;
  /// Robust visual chi-square per degree of freedom before rejection, at the calibration's noise
  /// (`slim`). Wrong minima sit at 1.5 to 30.
  double max_chi2 = 1.5;
  /// Cost of IMU factors and bias priors per residual row, at the widened noise of
  /// RefinementOptions (`slim`). One is what that noise predicts; recorded EuRoC IMUs have 0.15 to
  /// 0.21 over ten keyframes (medians). A sensor that vibrates more needs a larger
  /// accel_noise_factor.
  double max_inertial_chi2 = 1.0;
  /// The same below eight keyframes. Trajectories a tenth as large as they should be, which
  /// gravity, biases and first velocity of a second explain to the images' satisfaction, have 0.48
  /// and more; right ones 0.07 to 0.09 (medians).
  double max_inertial_chi2_short = 0.45;
  /// Share of the point sightings left after pruning and rejection (`slim`).
  double min_inlier_fraction = 0.6;
  /// Angle over which the points of an image are spread, rms [deg] (`slim`). Points in one spot are
  /// one point.
  double min_point_spread_deg = 2.0;
  /// Error of the extrinsic rotation that is beyond doubt (`slim`): what tracks and gyroscope say,
  /// less 2.5 standard deviations [deg]. Two degrees cost 2 % of scale, four 5 %, eight 15 %.
  double max_extrinsic_error_deg = 2.5;
  /// The same of the time offset between camera and IMU [s] (`slim`). 10 ms cost 5 % of scale, 20
  /// ms 10 to 20 %, without a trace in any other gate.
  double max_td_error_s = 0.008;
  /// Share of the point tracks behind the camera by over three sigma (`slim`).
  double max_behind_fraction = 0.2;

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// All options of an initializer.
struct InitializerOptions {
  ImuLimits imu;  ///< of the IMU stream
  WindowOptions window;
  VanishingPointOptions vanishing_point;
  AlignmentOptions alignment;
  RobustBiasOptions robust_bias;
  ReverseAlignmentOptions reverse_alignment;
  RefinementOptions refinement;
  SlimOptions slim;
  GateOptions gates;

  /// Returns an empty string, or the first sentence of a nested validate(), prefixed with the
  /// section ("window.keyframes is 1, must be at least 2").
  std::string validate() const;
};

}  // namespace slim_init
