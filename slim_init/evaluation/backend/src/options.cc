// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/backend/options.h"

#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

namespace slim_init::backend {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A value and the closed range it has to lie in.
struct Bounded {
  const char* name;
  double value, low, high;
};

template <std::size_t N>
std::string firstOutside(const Bounded (&fields)[N]) {
  for (const Bounded& field : fields) {
    if (field.value >= field.low && field.value <= field.high && std::isfinite(field.value)) {
      continue;
    }
    std::ostringstream out;
    out << field.name << " is " << field.value << ", must be at least " << field.low;
    if (field.high < kInfinity) out << " and at most " << field.high;
    return out.str();
  }
  return "";
}

constexpr double kTiny = 1e-12;  // of what has to be positive

}  // namespace

std::string EstimatorOptions::validate() const {
  return firstOutside({{"window_frames", double(window_frames), 4, 50},
                       {"max_iterations", double(max_iterations), 1, 1000},
                       {"min_parallax_px", min_parallax_px, 0, kInfinity},
                       {"min_tracked", double(min_tracked), 0, kInfinity},
                       {"visual_noise_factor", visual_noise_factor, kTiny, kInfinity},
                       {"cauchy_sigmas", cauchy_sigmas, kTiny, kInfinity},
                       {"gyro_noise_factor", gyro_noise_factor, kTiny, kInfinity},
                       {"accel_noise_factor", accel_noise_factor, kTiny, kInfinity},
                       {"gyro_bias_walk", gyro_bias_walk, kTiny, kInfinity},
                       {"accel_bias_walk", accel_bias_walk, kTiny, kInfinity},
                       {"start_window_s", start_window_s, 0.1, kInfinity},
                       {"default_depth_m", default_depth_m, kTiny, kInfinity},
                       {"anchor_position_m", anchor_position_m, kTiny, kInfinity},
                       {"anchor_yaw_rad", anchor_yaw_rad, kTiny, kInfinity},
                       {"seed_gyro_bias", seed_gyro_bias, kTiny, kInfinity},
                       {"seed_accel_bias", seed_accel_bias, kTiny, kInfinity},
                       {"imu_buffer_s", imu_buffer_s, 1, kInfinity}});
}

std::string FailureOptions::validate() const {
  return firstOutside({{"max_accel_bias", max_accel_bias, kTiny, kInfinity},
                       {"max_gyro_bias", max_gyro_bias, kTiny, kInfinity},
                       {"max_step_m", max_step_m, kTiny, kInfinity},
                       {"max_vertical_step_m", max_vertical_step_m, kTiny, kInfinity},
                       {"min_inlier_share", min_inlier_share, 0, 1},
                       {"min_judged_points", double(min_judged_points), 1, kInfinity}});
}

}  // namespace slim_init::backend
