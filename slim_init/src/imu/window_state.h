// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// State of the refinement and the layout of its error vector.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slim_init {

/// Motion of a window in the frame b0 of its first body. The first pose is the gauge: identity.
struct WindowState {
  std::vector<Eigen::Matrix3d> R_b0_bk;                  ///< attitudes, one per keyframe
  Eigen::Matrix3Xd p_b0;                                 ///< 3xN body positions [m]
  Eigen::Matrix3Xd v_b0;                                 ///< 3xN velocities [m/s]
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();   ///< [rad/s]
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();  ///< [m/s^2]
  Eigen::Vector3d gravity_b0 = Eigen::Vector3d::Zero();  ///< fixed length [m/s^2]

  int size() const { return static_cast<int>(R_b0_bk.size()); }
};

/// Where the parts of the error vector are:
///   [theta_0 p_0 .. theta_{N-1} p_{N-1} | v_0 .. v_{N-1} | b_g | b_a | gravity (2)].
/// theta on the right of R_b0_bk; gravity in tangentBasis(g / |g|), as an angle [rad]. The first
/// six are the gauge and never move.
struct StateLayout {
  explicit StateLayout(int keyframes) : n(keyframes) {}
  int n;
  static constexpr int kGauge = 6;
  int pose(int k) const { return 6 * k; }
  int velocity(int k) const { return 6 * n + 3 * k; }
  int gyroBias() const { return 9 * n; }
  int accelBias() const { return 9 * n + 3; }
  int gravity() const { return 9 * n + 6; }
  int size() const { return 9 * n + 8; }
};

/// Centre of camera k in b0 [m]; `t_b_c` of the calibration.
inline Eigen::Vector3d cameraCentre(const WindowState& state, int k, const Eigen::Vector3d& t_b_c) {
  return state.p_b0.col(k) + state.R_b0_bk[k] * t_b_c;
}

/// The state moved by the error vector `step` (StateLayout::size()).
WindowState retract(const WindowState& state, const Eigen::VectorXd& step);

}  // namespace slim_init
