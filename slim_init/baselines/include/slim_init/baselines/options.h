// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Parameters of the compared methods, with default, unit and reason (docs/baselines.md).
#pragma once

#include <string>

namespace slim_init::baselines {

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

/// Which lines enter the alignment and how they are weighted (paper IV-C-4).
struct LineSelectionOptions {
  int min_keyframes = 3;          ///< a persistent track is seen in at least this many keyframes
  int max_lines_per_pair = 10;    ///< best lines by score for each residual type
  double full_length_px = 200.0;  ///< length at which the length part of q^n reaches 1

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

/// Structureless visual-inertial bundle adjustment of `drt-vi-ba` (Song et al. 2025).
struct DrtViBaOptions {
  double sigma_px = 1.5;      ///< standard deviation of an epipolar residual [px], VINS-Mono's
  double huber_sigmas = 1.0;  ///< Huber scale of an epipolar residual, in standard deviations
  int max_iterations = 50;    ///< Levenberg-Marquardt steps
  double tolerance = 1e-6;    ///< relative decrease of the cost that ends the minimisation

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Parameters of `vins`; the values of VINS-Mono's release. Its pixels are those of a virtual
/// camera of 460 px focal length.
struct VinsOptions {
  /// Fundamental matrix between consecutive keyframes [px]; a track that disagrees starts anew. 0
  /// leaves it out: the release has it, at 1 px, in its tracker, from image to image, and the
  /// tracks of a window have been through a front end (docs/baselines.md measures it).
  double tracking_threshold_px = 0.0;
  int min_common_points = 20;        ///< the reference keyframe shares more with the newest
  double min_parallax_px = 30.0;     ///< .. and their mean motion, rotation included, is above
  double ransac_threshold_px = 0.3;  ///< of the five-point pose
  double ransac_confidence = 0.99;   ///< of both consensus searches
  int min_pose_inliers = 12;         ///< the five-point pose needs more in front of both cameras
  int min_pnp_points = 10;           ///< known points that a keyframe needs to be registered
  int max_iterations = 50;           ///< of the bundle adjustment; the release ends it by time
  double max_final_cost = 5e-3;      ///< not converged, it may still end at this cost (z = 1 plane)
  double max_gravity_residual = 1.0;  ///< unconstrained |g| against its true value [m/s^2]

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Parameters of `openvins`; the values of OpenVINS' release for EuRoC.
struct OpenVinsOptions {
  /// Longest tracks used; 0 uses all. The release tracks 50 points an image to save time.
  int max_features = 0;
  int min_features = 8;            ///< tracks in front of the camera
  double min_rotation_deg = 10.0;  ///< summed rotation of the gyroscope, bias included; less waits
  double sigma_px = 1.0;           ///< standard deviation of an observation
  double cauchy_sigmas = 1.0;      ///< Cauchy scale of an observation, in standard deviations
  double gyro_bias_prior = 0.05;   ///< standard deviation about zero [rad/s]
  double accel_bias_prior = 0.10;  ///< standard deviation about zero [m/s^2]
  double gyro_walk = 1.9393e-5;    ///< random walk of the bias [rad/s^2/sqrt(Hz)]
  double accel_walk = 3.0e-3;      ///< random walk of the bias [m/s^3/sqrt(Hz)]
  int max_iterations = 50;  ///< of the refinement; 0 leaves it out, the release also at 0.05 s
  /// Further refinements with the IMU integrated anew at the refined biases; the release has none.
  int relinearizations = 1;
  double function_tolerance = 1e-5;  ///< relative decrease of the cost that ends it

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Parameters that only compared methods have. What they share with `slim` (vanishing points,
/// translations, gates) is in InitializerOptions.
struct BaselineOptions {
  GyroBiasOptions gyro_bias;
  LineSelectionOptions line_selection;
  SlimPaperOptions slim_paper;
  DrtViBaOptions drt_vi_ba;
  VinsOptions vins;
  OpenVinsOptions openvins;

  /// Returns an empty string, or the first message of a nested validate(), prefixed with the
  /// section.
  std::string validate() const;
};

}  // namespace slim_init::baselines
