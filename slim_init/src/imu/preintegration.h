// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// IMU preintegration on SO(3) (Forster et al. 2016, sections V and VI), trapezoidal between
// samples, and what follows from it for states.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/so3.h"
#include "slim_init/init_window.h"
#include "slim_init/state_prior.h"
#include "slim_init/types.h"

namespace slim_init {

/// Motion between the instants i and j as the IMU alone sees it.
///
///   R_w_bj = R_w_bi dR,   v_j = v_i + g dt + R_w_bi dv,
///   p_j = p_i + v_i dt + g dt^2 / 2 + R_w_bi dp.
struct Preintegration {
  double dt = 0.0;                                   ///< t_j - t_i [s]
  Eigen::Matrix3d dR = Eigen::Matrix3d::Identity();  ///< b_j to b_i
  Eigen::Vector3d dv = Eigen::Vector3d::Zero();      ///< in b_i [m/s]
  Eigen::Vector3d dp = Eigen::Vector3d::Zero();      ///< in b_i [m]

  // Derivatives at the linearisation point; for the rotation dR(b_g + d) = dR Exp(dR_dbg d).
  Eigen::Matrix3d dR_dbg = Eigen::Matrix3d::Zero();  ///< [rad / (rad/s)]
  Eigen::Matrix3d dv_dbg = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d dv_dba = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d dp_dbg = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d dp_dba = Eigen::Matrix3d::Zero();

  /// Covariance of the errors [theta, v, p] with dR Exp(theta), dv + v, dp + p. Zero unless asked
  /// for (PreintegrationParts::kWithCovariance).
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();

  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();   ///< linearisation point [rad/s]
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();  ///< linearisation point [m/s^2]

  // First-order values at other biases (Forster et al. 2016, eq. (44)).
  Eigen::Vector3d velocityAt(const Eigen::Vector3d& bg, const Eigen::Vector3d& ba) const {
    return dv + dv_dbg * (bg - gyro_bias) + dv_dba * (ba - accel_bias);
  }
  Eigen::Vector3d positionAt(const Eigen::Vector3d& bg, const Eigen::Vector3d& ba) const {
    return dp + dp_dbg * (bg - gyro_bias) + dp_dba * (ba - accel_bias);
  }
};

/// Samples this many intervals apart have others missing between them; so have averages of samples.
inline constexpr double kMissing = 1.5;

/// Biases that samples are integrated at: the linearisation point.
struct BiasPoint {
  Eigen::Vector3d gyro;   ///< [rad/s]
  Eigen::Vector3d accel;  ///< [m/s^2]
};

/// What to compute; less is faster.
enum class PreintegrationParts {
  kRotation,        ///< dt, dR, dR_dbg
  kMean,            ///< and dv, dp and all derivatives
  kWithCovariance,  ///< and the covariance
};

/// Integrates from t_i to t_j. `samples` ascend in time and cover [t_i, t_j]; values at t_i and t_j
/// are interpolated linearly between the neighbouring samples, so that a keyframe between two
/// samples is met exactly. Requires t_i < t_j. Samples outside the interval say only how long an
/// interval between samples is on average: the covariance is widened where one is longer than 1.5
/// of it, for others are missing there.
Preintegration preintegrate(const std::vector<ImuSample>& samples, double t_i, double t_j,
                            const BiasPoint& biases, const ImuNoise& noise,
                            PreintegrationParts parts);

/// As much of a shift of the keyframe times [s] as the IMU of the window covers.
double coveredShift(const InitWindow& window, double shift);

/// One preintegration per consecutive keyframe pair of the window (size() - 1 of them), between the
/// keyframe times moved by `td_shift` [s]. The IMU has to cover them there.
std::vector<Preintegration> preintegrateWindow(const InitWindow& window, const BiasPoint& biases,
                                               const ImuNoise& noise, double td_shift,
                                               PreintegrationParts parts);
/// The same between the keyframe times, with the noise of the data sheet.
std::vector<Preintegration> preintegrateWindow(const InitWindow& window,
                                               const Eigen::Vector3d& gyro_bias,
                                               const Eigen::Vector3d& accel_bias,
                                               PreintegrationParts parts);

/// Carries a state on by one preintegration made at the state's biases. `gravity_w` [m/s^2].
NavState propagate(const NavState& state_i, const Preintegration& pre,
                   const Eigen::Vector3d& gravity_w);

/// The state at time `t` [s], propagated by `samples` at its own biases; unchanged where `t` is not
/// later.
NavState propagateTo(const NavState& state, double t, const std::vector<ImuSample>& samples,
                     const Eigen::Vector3d& gravity_w);

/// Body attitudes in the first body frame, R_b0_bk, by chaining the relative rotations.
std::vector<Eigen::Matrix3d> chainRotations(const std::vector<Preintegration>& pre);

/// Rotations of the cameras into the first camera from those of the bodies into the first body.
std::vector<Eigen::Matrix3d> cameraRotations(const std::vector<Eigen::Matrix3d>& R_b0_bk,
                                             const Eigen::Matrix3d& R_b_c);

/// Motion of the IMU at one instant, biases taken off.
struct ImuInstant {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();   ///< [rad/s]
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< specific force [m/s^2]
};

/// Means of the samples within 12 ms of each keyframe moved by `td_shift` [s], less the biases
/// [rad/s, m/s^2]. Without one the sample after it, the last one at the end.
std::vector<ImuInstant> imuInstants(const InitWindow& window, double td_shift,
                                    const Eigen::Vector3d& gyro_bias,
                                    const Eigen::Vector3d& accel_bias);

/// `prior` at time `t` [s], not before it. `samples` ascend and cover the time between; `noise` as
/// the data sheet has it, widened here to that of a sensor in motion (docs/derivation.md, 5.3).
StatePrior propagatePrior(const StatePrior& prior, double t, const std::vector<ImuSample>& samples,
                          double gravity_magnitude, const ImuNoise& noise);

}  // namespace slim_init
