// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Reverse alignment of `slim`: the IMU's trajectory is fitted to the visual shape, not the other
// way round.
//
// In the alignment of DRT the noisy visual displacements multiply the unknown scale, and noise on a
// regressor shrinks its coefficient. Here the camera centres C(x) = A x + c0 that the IMU predicts
// are linear in x = [v_0, b_a, g], the visual shape is the measurement, and the inverse scale u
// runs over a line search. The accelerometer bias is one of the unknowns.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "imu/preintegration.h"
#include "imu/window_state.h"

namespace slim_init {

/// Positions and velocities as the IMU predicts them in b0, linear in x = [v_0, b_a, g]; b_a is
/// what the preintegrations lack of the accelerometer bias.
struct LinearMotion {
  std::vector<Eigen::Matrix3d> R_b0_bk;               ///< as given
  Eigen::Vector3d gyro_bias, accel_bias;              ///< of the preintegrations
  Eigen::Matrix<double, Eigen::Dynamic, 9> position;  ///< 3N x 9, of the body
  Eigen::VectorXd position0;                          ///< 3N
  Eigen::Matrix<double, Eigen::Dynamic, 9> velocity;  ///< 3N x 9
  Eigen::VectorXd velocity0;                          ///< 3N
  Eigen::VectorXd lever;                              ///< 3N, R_b0_bk t_b_c: body to camera centre
  /// Measured velocities cost x^T M x - 2 b^T x + c: M, b, c; zero without any.
  Eigen::Matrix<double, 9, 9> speed_information = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix<double, 9, 1> speed_gradient = Eigen::Matrix<double, 9, 1>::Zero();
  double speed_cost = 0.0;

  /// The motion at x.
  WindowState at(const Eigen::Matrix<double, 9, 1>& x) const;
};

/// Chains the preintegrations (made with derivatives) with given attitudes.
LinearMotion linearMotion(const std::vector<Preintegration>& pre,
                          const std::vector<Eigen::Matrix3d>& R_b0_bk,
                          const Eigen::Vector3d& t_b_c);

/// Information that holds the shape along itself (kappa), in units of its mean diagonal: stiff
/// enough that the rest cannot stretch it, far from what rounding allows.
inline constexpr double kLengthWeight = 1e3;

/// Solution of the reverse alignment.
struct ReverseEstimate {
  bool valid = false;
  double scale = kNotComputed;  ///< metres per unit of the visual shape
  Eigen::Matrix<double, 9, 1> x = Eigen::Matrix<double, 9, 1>::Zero();  ///< of the motion
};

/// Minimises over u and x
///   u^2 C^T H C + kappa (u c^T C - 1)^2 + |b_a|^2 / sigma_ba^2,   |g| fixed,
/// and the cost of measured velocities, with the visual shape c (3xN, in b0, unit spread about its
/// mean) and its information H (3N x 3N, in b0, for a shape of unit spread). The second term fixes
/// the length of u C along the shape. Each u is a small least-squares problem with a fixed |g|; u
/// by a logarithmic grid, then a bracketed search. Fails (valid == false) on input that is not
/// finite or a singular problem.
ReverseEstimate alignReverse(const LinearMotion& motion, const Eigen::Matrix3Xd& shape_b0,
                             const Eigen::MatrixXd& information_b0, double gravity_magnitude,
                             double accel_bias_prior);

}  // namespace slim_init
