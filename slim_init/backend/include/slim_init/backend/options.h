// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Every number of the sliding-window back end.
#pragma once

namespace slim_init::backend {

/// SlidingWindowEstimator. Sizes and rules are those that Qin et al. (2018) publish for VINS-Mono.
struct EstimatorOptions {
  int window_frames = 11;  ///< ten keyframes and the newest frame
  int max_iterations = 8;  ///< Levenberg-Marquardt iterations per frame
  /// Mean rotation-compensated motion of the tracks between the last keyframe and the frame after
  /// it, above which that frame becomes a keyframe [px].
  double min_parallax_px = 10.0;
  int min_tracked = 20;  ///< fewer continued tracks make a keyframe as well

  double visual_noise_factor =
      1.5;                     ///< on Calibration::sigma_px; a track's first view is noisy too
  double cauchy_sigmas = 2.0;  ///< Cauchy scale of a reprojection, in standard deviations
  /// On the calibration's densities: sensors in motion are noisier than their data sheet.
  double gyro_noise_factor = 3.0;
  double accel_noise_factor = 5.0;
  double gyro_bias_walk = 2e-5;   ///< [rad/s^2/sqrt(Hz)], of the order of EuRoC's ADIS16448
  double accel_bias_walk = 3e-3;  ///< [m/s^3/sqrt(Hz)], likewise

  /// While there is no start, frames older than this leave the window [s]: an initializer's window
  /// does not reach further back.
  double start_window_s = 2.2;
  double default_depth_m = 5.0;     ///< of a point without parallax, as a start
  double anchor_position_m = 1e-3;  ///< holds the free position of the window after a seed
  double anchor_yaw_rad = 1e-3;     ///< holds its free heading
  double seed_gyro_bias = 0.02;     ///< trust in the seed's gyro bias, 1 sigma [rad/s]
  double seed_accel_bias = 0.2;     ///< trust in its accelerometer bias, 1 sigma [m/s^2]
  double imu_buffer_s = 10.0;       ///< samples kept while there is no window
};

/// Failure detection by the published rules of VINS-Mono (Qin et al. 2018, section VIII-A; bounds
/// as in its release), and one of our own: by those rules alone an estimator that an IMU spike has
/// thrown off flies away at ten metres per second unnoticed.
struct FailureOptions {
  double max_accel_bias = 2.5;       ///< [m/s^2]
  double max_gyro_bias = 1.0;        ///< [rad/s]
  double max_step_m = 5.0;           ///< between two newest states
  double max_vertical_step_m = 1.0;  ///< likewise, along gravity

  /// Minimum fraction of the newest frame's known points that are where the window predicts them; a
  /// frame with fewer than min_judged_points of them is not judged.
  double min_inlier_share = 0.5;
  int min_judged_points = 10;
};

}  // namespace slim_init::backend
