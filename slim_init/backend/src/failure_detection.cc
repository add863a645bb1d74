// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <sstream>

#include "slim_init/backend/sliding_window_estimator.h"

namespace slim_init::backend {

std::string detectFailure(const NavState& previous, const NavState& current,
                          const FrameReport& report, const FailureOptions& options) {
  std::ostringstream out;
  const Eigen::Vector3d step = current.p_w_b - previous.p_w_b;
  // Written so that a value that is not finite fails.
  if (!(current.accel_bias.norm() <= options.max_accel_bias)) {
    out << "accelerometer bias " << current.accel_bias.norm() << " m/s^2 (limit "
        << options.max_accel_bias << ")";
  } else if (!(current.gyro_bias.norm() <= options.max_gyro_bias)) {
    out << "gyroscope bias " << current.gyro_bias.norm() << " rad/s (limit "
        << options.max_gyro_bias << ")";
  } else if (!(step.norm() <= options.max_step_m)) {
    out << "step between two frames " << step.norm() << " m (limit " << options.max_step_m << ")";
  } else if (!(std::abs(step.z()) <= options.max_vertical_step_m)) {
    out << "vertical step between two frames " << std::abs(step.z()) << " m (limit "
        << options.max_vertical_step_m << ")";
  } else if (report.newest_views >= options.min_judged_points &&
             report.newest_inliers < options.min_inlier_share * report.newest_views) {
    out << report.newest_inliers << " of " << report.newest_views
        << " points are where they are expected (minimum fraction " << options.min_inlier_share
        << ")";
  }
  return out.str();
}

}  // namespace slim_init::backend
