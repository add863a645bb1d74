// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Parameters of the compared methods, with the values of their papers and releases
// (docs/baselines.md). No keys of a configuration file.
#pragma once

namespace slim_init::baselines {

/// Which lines enter the alignment and how they are weighted (paper IV-C-4).
struct LineSelectionOptions {
  int min_keyframes = 3;          ///< minimum length of a line track [keyframes]
  int max_lines_per_pair = 10;    ///< best lines by score for each residual type
  double full_length_px = 200.0;  ///< length at which the length part of q^n reaches 1 [px]
};

/// The switches of `slim-paper`, one per term, and the proportionality constants that the paper
/// leaves open (docs/baselines.md measures them).
struct SlimPaperOptions {
  bool use_vp = true;                      ///< VP residual in step 1, eq. (4)
  bool use_line_epipolar = true;           ///< eq. (11)
  bool use_line_normal = true;             ///< eq. (12)
  int min_track_age = 2;                   ///< A_min of the paper [keyframes]
  double consistency_threshold_deg = 0.5;  ///< largest rms of the inliers; t_vp [deg]
  double vp_weight = 0.001;                ///< factor on lambda_vp
  double vp_cauchy_scale = 0.05;           ///< Cauchy scale of the VP residual [rad]
  double line_epipolar_weight = 0.01;      ///< constant of eq. (13), type e
  double line_normal_weight = 1.0;         ///< constant of eq. (13), type n
};

/// Structureless visual-inertial bundle adjustment of `drt-vi-ba` (Song et al. 2025).
struct DrtViBaOptions {
  double sigma_px = 1.5;      ///< standard deviation of an epipolar residual [px]
  double huber_sigmas = 1.0;  ///< Huber scale of an epipolar residual [sigma]
  int max_iterations = 50;    ///< Levenberg-Marquardt steps
  double tolerance = 1e-6;    ///< relative decrease of the cost that ends the minimisation
};

/// Parameters of `vins`; the values of VINS-Mono's release. Its pixels are those of a virtual
/// camera of 460 px focal length.
struct VinsOptions {
  int min_common_points = 20;         ///< the reference keyframe shares more with the newest
  double min_parallax_px = 30.0;      ///< minimum mean motion of these points [px]
  double ransac_threshold_px = 0.3;   ///< of the five-point pose [px]
  double ransac_confidence = 0.99;    ///< of its consensus search
  int min_pose_inliers = 12;          ///< points in front of both cameras of the five-point pose
  int min_pnp_points = 10;            ///< known points that a keyframe needs to be registered
  int max_iterations = 50;            ///< of the bundle adjustment
  double max_final_cost = 5e-3;       ///< cost at which it may end without convergence
  double max_gravity_residual = 1.0;  ///< unconstrained |g| against its true value [m/s^2]
};

/// Parameters of `openvins`; the values of OpenVINS' release for EuRoC.
struct OpenVinsOptions {
  int min_features = 8;              ///< tracks in front of the camera
  double min_rotation_deg = 10.0;    ///< summed rotation of the gyroscope [deg]
  double sigma_px = 1.0;             ///< standard deviation of an observation [px]
  double cauchy_sigmas = 1.0;        ///< Cauchy scale of an observation [sigma]
  double gyro_bias_prior = 0.05;     ///< standard deviation about zero [rad/s]
  double accel_bias_prior = 0.10;    ///< standard deviation about zero [m/s^2]
  double gyro_walk = 1.9393e-5;      ///< random walk of the bias [rad/s^2/sqrt(Hz)]
  double accel_walk = 3.0e-3;        ///< random walk of the bias [m/s^3/sqrt(Hz)]
  int max_iterations = 50;           ///< of the refinement
  int relinearizations = 1;          ///< further refinements with the IMU integrated again
  double function_tolerance = 1e-5;  ///< relative decrease of the cost that ends it
};

/// Parameters that only compared methods have. What they share with `slim` (vanishing points,
/// translations, gates) is in InitializerOptions.
struct BaselineOptions {
  LineSelectionOptions line_selection;  ///< slim-paper
  SlimPaperOptions slim_paper;          ///< slim-paper
  DrtViBaOptions drt_vi_ba;             ///< drt-vi-ba
  VinsOptions vins;                     ///< vins
  OpenVinsOptions openvins;             ///< openvins
};

}  // namespace slim_init::baselines
