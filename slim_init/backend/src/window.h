// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Frames of the window as parameter blocks.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/so3.h"
#include "slim_init/types.h"

namespace slim_init::backend {

using FrameId = std::int64_t;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Vector9d = Eigen::Matrix<double, 9, 1>;

constexpr int kPoseSize = 6;    ///< p_w_b, theta with R_w_b = R_ref Exp(theta)
constexpr int kMotionSize = 9;  ///< v_w_b, b_g, b_a

/// State of one frame. The attitude is counted from a reference that follows it between solves, so
/// that the optimiser sees vectors and theta stays small.
struct Frame {
  FrameId id = -1;
  double t = 0.0;      ///< IMU clock [s]
  double stamp = 0.0;  ///< camera clock [s]
  Eigen::Matrix3d R_ref = Eigen::Matrix3d::Identity();
  std::array<double, kPoseSize> pose{};
  std::array<double, kMotionSize> motion{};

  Eigen::Map<const Vector6d> poseVector() const { return Eigen::Map<const Vector6d>(pose.data()); }
  Eigen::Map<const Vector9d> motionVector() const {
    return Eigen::Map<const Vector9d>(motion.data());
  }
  Eigen::Vector3d position() const { return poseVector().head<3>(); }
  Eigen::Matrix3d rotation() const { return R_ref * expSO3(poseVector().tail<3>()); }
  Eigen::Vector3d gyroBias() const { return motionVector().segment<3>(3); }
  Eigen::Vector3d accelBias() const { return motionVector().tail<3>(); }

  NavState state() const {
    NavState out;
    out.t = t;
    out.R_w_b = rotation();
    out.p_w_b = position();
    out.v_w_b = motionVector().head<3>();
    out.gyro_bias = gyroBias();
    out.accel_bias = accelBias();
    return out;
  }
  void set(const NavState& state) {
    R_ref = state.R_w_b;
    Eigen::Map<Vector6d>(pose.data()) << state.p_w_b, Eigen::Vector3d::Zero();
    Eigen::Map<Vector9d>(motion.data()) << state.v_w_b, state.gyro_bias, state.accel_bias;
  }
  /// Moves theta into the reference, renormalised: the product of many rotations drifts off SO(3).
  void rebase() {
    R_ref = Eigen::Quaterniond(rotation()).normalized().toRotationMatrix();
    Eigen::Map<Vector6d>(pose.data()).tail<3>().setZero();
  }
};

/// Frames in time order; addresses of parameter blocks stay while a frame is held.
using Frames = std::vector<std::unique_ptr<Frame>>;

/// The frame of that id, or null.
inline Frame* findFrame(const Frames& frames, FrameId id) {
  for (const auto& frame : frames) {
    if (frame->id == id) return frame.get();
  }
  return nullptr;
}

}  // namespace slim_init::backend
