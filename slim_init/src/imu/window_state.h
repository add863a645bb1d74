// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// State of the refinement and the layout of its error vector.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slim_init {

/// The rig against the calibration of the window: R_b_c dR, t_b_c + dt, td + dtd, readout_s +
/// dreadout.
struct RigError {
  Eigen::Matrix3d dR = Eigen::Matrix3d::Identity();
  Eigen::Vector3d dt = Eigen::Vector3d::Zero();  ///< [m]
  double dtd = 0.0;                              ///< [s]
  double dreadout = 0.0;                         ///< [s]
};

/// Motion of a window in the frame b0 of its first body. The first pose is the gauge: identity.
///
/// With a rig error, attitudes and positions are those of the body that the camera would have under
/// the calibration of the window, so that everything visual is free of the error; velocities and
/// gravity are in the frame of the first of them. bodyState() has the body itself.
struct WindowState {
  std::vector<Eigen::Matrix3d> R_b0_bk;                  ///< attitudes, one per keyframe
  Eigen::Matrix3Xd p_b0;                                 ///< 3xN body positions [m]
  Eigen::Matrix3Xd v_b0;                                 ///< 3xN velocities [m/s]
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();   ///< [rad/s]
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();  ///< [m/s^2]
  Eigen::Vector3d gravity_b0 = Eigen::Vector3d::Zero();  ///< fixed length [m/s^2]
  RigError rig;                                          ///< none where it is not estimated

  int size() const { return static_cast<int>(R_b0_bk.size()); }
};

/// Where the parts of the error vector are:
///   [theta_0 p_0 .. theta_{N-1} p_{N-1} | v_0 .. v_{N-1} | b_g | b_a | gravity (2)
///    | rotation (3), translation (3), td, readout].
/// theta on the right of R_b0_bk; gravity in tangentBasis(g / |g|), as an angle [rad]; rotation on
/// the right of RigError::dR. The first six are the gauge and never move. Without a rig error the
/// last eight are absent.
struct StateLayout {
  explicit StateLayout(int keyframes, bool with_rig = false) : n(keyframes), rigs(with_rig) {}
  int n;
  bool rigs;  ///< the rig error is part of the vector
  static constexpr int kGauge = 6;
  static constexpr int kRig = 8;
  int pose(int k) const { return 6 * k; }
  int velocity(int k) const { return 6 * n + 3 * k; }
  int gyroBias() const { return 9 * n; }
  int accelBias() const { return 9 * n + 3; }
  int gravity() const { return 9 * n + 6; }
  int rig() const { return 9 * n + 8; }
  int td() const { return rig() + 6; }
  int readout() const { return rig() + 7; }
  int size() const { return 9 * n + 8 + (rigs ? kRig : 0); }
};

/// Centre of camera k in b0 [m]; `t_b_c` of the calibration.
inline Eigen::Vector3d cameraCentre(const WindowState& state, int k, const Eigen::Vector3d& t_b_c) {
  return state.p_b0.col(k) + state.R_b0_bk[k] * t_b_c;
}

/// The state moved by the error vector `step` (StateLayout::size(), with or without a rig error).
WindowState retract(const WindowState& state, const Eigen::VectorXd& step);

/// The body itself: attitudes, positions, velocities and gravity of the body at the exposures, in
/// the frame of the first of them. `R_b_c` and `t_b_c` of the window's calibration. The rig error
/// is kept.
WindowState bodyState(const WindowState& state, const Eigen::Matrix3d& R_b_c,
                      const Eigen::Vector3d& t_b_c);

}  // namespace slim_init
