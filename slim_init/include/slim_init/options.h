// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Every number a user may turn, with default, unit and reason. Configuration keys are the field
// names (config/README.md).
#pragma once

#include <string>

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

/// Step 1, gyroscope bias from points (Kneip and Lynen 2013, He et al. 2023).
struct GyroBiasOptions {
  int max_iterations = 30;       ///< Levenberg-Marquardt iterations per linearisation of the IMU
  int max_relinearizations = 4;  ///< re-integrations of the gyro at the new bias
  double cauchy_scale = 1e-5;    ///< Cauchy scale of a pair's residual [rad^2]; DRT's release
  int min_points_per_pair = 6;   ///< pairs with fewer common tracks do not enter
  double max_bias = 1.0;         ///< [rad/s] a larger answer is a numerical failure

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Gyroscope bias of `slim`: noise-normalised epipolar cost over keyframe pairs 1, 2, 4 and 8
/// apart.
struct MultiGapBiasOptions {
  int max_gap = 8;              ///< largest gap used; 1 leaves consecutive pairs only (ablation)
  int min_points_per_pair = 6;  ///< pairs with fewer common tracks do not enter
  int reweightings = 3;         ///< rounds of robust weights
  int max_iterations = 10;      ///< Levenberg-Marquardt iterations per round
  double cauchy_sigmas = 3.0;   ///< Cauchy scale, in standard deviations of a residual
  double vp_inflation = 4.0;    ///< on the VP covariance: clutter among the inliers is not in it
  double bias_prior = 0.2;      ///< standard deviation of the bias before any data [rad/s]
  double max_bias = 1.0;        ///< [rad/s] a larger answer is a numerical failure

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

/// Which lines enter the alignment and how they are weighted (paper IV-C-4).
struct LineSelectionOptions {
  int min_keyframes = 3;          ///< a persistent track is seen in at least this many keyframes
  int max_lines_per_pair = 10;    ///< best lines by score for each residual type
  double full_length_px = 200.0;  ///< length at which the length part of q^n reaches 1

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Step 2, LiGT translations (Cai et al. 2021) and linear alignment.
struct AlignmentOptions {
  int min_track_length = 3;        ///< keyframes; two views say nothing about relative scale
  int min_tracks = 8;              ///< fewer tracks of that length are "too_few_tracks"
  double min_parallax_rad = 1e-4;  ///< tracks with less rotation-compensated parallax are left out

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

/// The switches of `slim-paper`, one per term, and the proportionality constants that the paper
/// leaves open (docs/method_slim_paper.md measures them).
struct SlimPaperOptions {
  bool use_vp = true;             ///< VP residual in step 1, eq. (4)
  bool use_line_epipolar = true;  ///< eq. (11)
  bool use_line_normal = true;    ///< eq. (12)
  /// Multiplies lambda_vp, the point to VP residual count ratio. At 1 the VP term dominates and the
  /// bias error grows several times, because a VP is about ten times noisier than a point bearing
  /// (sweep in docs/method_slim_paper.md).
  double vp_weight = 0.001;
  double vp_cauchy_scale = 0.05;       ///< Cauchy scale of the VP residual [rad]
  double line_epipolar_weight = 0.01;  ///< constant of eq. (13), type e; above 0.1 success falls
  double line_normal_weight = 1.0;     ///< constant of eq. (13), type n; 1 is best or near it

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
  /// Rotation-compensated track motion over the window, median [px]; less is "no translation".
  double min_parallax_px = 3.0;
  /// Rotation over the window [deg]; less, without translation, is stationary, more is a pure
  /// rotation.
  double min_rotation_deg = 2.0;
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

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// All options of an initializer.
struct InitializerOptions {
  WindowOptions window;
  GyroBiasOptions gyro_bias;
  VanishingPointOptions vanishing_point;
  LineSelectionOptions line_selection;
  AlignmentOptions alignment;
  SlimPaperOptions slim_paper;
  GateOptions gates;

  /// Returns an empty string, or the first sentence of a nested validate(), prefixed with the
  /// section ("window.keyframes is 1, must be at least 2").
  std::string validate() const;
};

}  // namespace slim_init
