// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <sstream>

#include "slim_init/backend/sliding_window_estimator.h"

namespace slim_init::backend {
namespace {

constexpr double kMaxAccelBias = 2.5;     // [m/s^2]
constexpr double kMaxGyroBias = 1.0;      // [rad/s]
constexpr double kMaxStep = 5.0;          // between two newest states [m]
constexpr double kMaxVerticalStep = 1.0;  // likewise, along gravity [m]
// Minimum fraction of the newest frame's known points that are where the window predicts them; a
// frame with fewer points than the second number is not judged.
constexpr double kMinInlierFraction = 0.5;
constexpr int kMinJudgedPoints = 10;

}  // namespace

std::string detectFailure(const NavState& previous, const NavState& current,
                          const FrameReport& report) {
  std::ostringstream out;
  const Eigen::Vector3d step = current.p_w_b - previous.p_w_b;
  // Written so that a value that is not finite fails.
  if (!(current.accel_bias.norm() <= kMaxAccelBias)) {
    out << "accelerometer bias " << current.accel_bias.norm() << " m/s^2 (limit " << kMaxAccelBias
        << ")";
  } else if (!(current.gyro_bias.norm() <= kMaxGyroBias)) {
    out << "gyroscope bias " << current.gyro_bias.norm() << " rad/s (limit " << kMaxGyroBias << ")";
  } else if (!(step.norm() <= kMaxStep)) {
    out << "step between two frames " << step.norm() << " m (limit " << kMaxStep << ")";
  } else if (!(std::abs(step.z()) <= kMaxVerticalStep)) {
    out << "vertical step between two frames " << std::abs(step.z()) << " m (limit "
        << kMaxVerticalStep << ")";
  } else if (report.newest_views >= kMinJudgedPoints &&
             report.newest_inliers < kMinInlierFraction * report.newest_views) {
    out << report.newest_inliers << " of " << report.newest_views
        << " points are where they are expected (minimum fraction " << kMinInlierFraction << ")";
  }
  return out.str();
}

}  // namespace slim_init::backend
