// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/backend/options.h"

#include "data/range_check.h"

namespace slim_init::backend {
namespace {

constexpr double kTiny = 1e-12, kLarge = 1e12;  // where a value only has to be positive or finite

}  // namespace

std::string EstimatorOptions::validate() const {
  return RangeCheck()
      .within("window_frames", window_frames, 4, 50)
      .within("max_iterations", max_iterations, 1, 1000)
      .within("min_parallax_px", min_parallax_px, 0.0, kLarge)
      .within("min_tracked", min_tracked, 0, 1000000)
      .within("visual_noise_factor", visual_noise_factor, kTiny, kLarge)
      .within("cauchy_sigmas", cauchy_sigmas, kTiny, kLarge)
      .within("gyro_noise_factor", gyro_noise_factor, kTiny, kLarge)
      .within("accel_noise_factor", accel_noise_factor, kTiny, kLarge)
      .within("gyro_bias_walk", gyro_bias_walk, kTiny, kLarge)
      .within("accel_bias_walk", accel_bias_walk, kTiny, kLarge)
      .within("start_window_s", start_window_s, 0.1, kLarge)
      .within("default_depth_m", default_depth_m, kTiny, kLarge)
      .within("anchor_position_m", anchor_position_m, kTiny, kLarge)
      .within("anchor_yaw_rad", anchor_yaw_rad, kTiny, kLarge)
      .within("seed_gyro_bias", seed_gyro_bias, kTiny, kLarge)
      .within("seed_accel_bias", seed_accel_bias, kTiny, kLarge)
      .within("imu_buffer_s", imu_buffer_s, 1.0, kLarge)
      .message();
}

std::string FailureOptions::validate() const {
  return RangeCheck()
      .within("max_accel_bias", max_accel_bias, kTiny, kLarge)
      .within("max_gyro_bias", max_gyro_bias, kTiny, kLarge)
      .within("max_step_m", max_step_m, kTiny, kLarge)
      .within("max_vertical_step_m", max_vertical_step_m, kTiny, kLarge)
      .within("min_inlier_share", min_inlier_share, 0.0, 1.0)
      .within("min_judged_points", min_judged_points, 1, 1000000)
      .message();
}

}  // namespace slim_init::backend
