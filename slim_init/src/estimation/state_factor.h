// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A known state of the first body as a factor of the estimate, and the test whether the data of the
// window contradict it (docs/derivation.md, 5.3). Position and heading are the gauge of a window
// and take no part.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "estimation/inertial_factor.h"
#include "imu/window_state.h"
#include "slim_init/state_prior.h"

namespace slim_init {

/// Standard deviations of the parts of a state (StatePart) of which nothing is known: velocity of a
/// fast vehicle [m/s], attitude [rad], biases of the worst sensors [rad/s, m/s^2].
inline constexpr double kUnknown[] = {30.0, 1.0, 0.3, 1.0};

/// Rows: velocity in the body (3), direction of gravity (2), b_g (3), b_a (3).
constexpr int kStateRows = 11;
/// Columns: v_0 (3), b_g (3), b_a (3), gravity (2), rotation, translation, td of the rig (7).
constexpr int kStateColumns = 11 + StateLayout::kRig - 1;

using StateVector = Eigen::Matrix<double, kStateRows, 1>;
using StateCovariance = Eigen::Matrix<double, kStateRows, kStateRows>;

/// The parts of a state that can be wrong by themselves.
enum class StatePart { kVelocity, kGravity, kGyroBias, kAccelBias };
constexpr int kStateParts = 4;
/// "velocity", "gravity", "gyro_bias", "accel_bias": for messages.
const char* toString(StatePart part);

/// What is known of the body at the time of the first keyframe.
struct StateFactor {
  Eigen::Vector3d velocity_b = Eigen::Vector3d::Zero();  ///< in the body [m/s]
  Eigen::Vector3d down_b = -Eigen::Vector3d::UnitZ();    ///< direction of gravity in the body
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();   ///< [rad/s]
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();  ///< [m/s^2]
  StateCovariance covariance = StateCovariance::Zero();  ///< of the rows, truth minus estimate
  /// The tracks have no parallax: their depths would be made of noise, and the velocity with them.
  /// Points are then directions.
  bool points_at_infinity = false;

  /// With the largest standard deviation of an axis.
  ImuBiases biases() const;
};

/// Rows of the errors of StateFactor by those of StatePrior [theta, p, v, b_g, b_a].
Eigen::Matrix<double, kStateRows, 15> stateRows(const NavState& state);

/// The factor of a prior at the time of the first keyframe.
StateFactor stateFactor(const StatePrior& prior);

/// Estimate minus prior, and its derivatives.
struct StateResidual {
  StateVector r;
  Eigen::Matrix<double, kStateRows, kStateColumns> J;
};

/// `state`: of a window with the calibration `calibration`; `first`: motion of its first body,
/// which is taken at the time of its prior (bodyAtNominalTime() with the whole error of td).
StateResidual stateResidual(const WindowState& state, const StateFactor& factor,
                            const Calibration& calibration, const ImuInstant& first);

/// The covariance with one part as good as unknown, and with it what follows from it in the others.
StateCovariance without(const StateCovariance& covariance, StatePart part);

/// How far the data of a window are from a prior, in squared standard deviations of both together.
struct StateTest {
  double total = 0.0;  ///< of all parts
  int freedom = 0;     ///< directions about which the data say anything
  /// By how much the total falls when the part is not used.
  std::array<double, kStateParts> part{};

  /// Whether it is beyond what chance does in one of a thousand, in all or in a part.
  bool contradicts() const;
  bool contradicts(StatePart which) const;  ///< in this part
  double bound() const;                     ///< on `total`
};

/// `r` of the estimate that contains the prior with `covariance`; `posterior`: covariance of the
/// rows in that estimate.
StateTest testState(const StateVector& r, const StateCovariance& covariance,
                    const StateCovariance& posterior);

/// The same of a prior against an independent estimate of the same body. The sum of both
/// covariances has to be positive definite.
StateTest testDifference(const StateFactor& prior, const StateFactor& estimate);

/// What is known about the motion of a vehicle before any data (docs/derivation.md, 5.2):
/// independent Gaussians about zero, of each axis. In a window of a few tenths of a second the
/// images leave the scale to the accelerometer, which has hardly begun to see it; without this the
/// estimate may be at any speed.
struct MotionPrior {
  double speed_sigma = 2.0;         ///< of the velocity at the middle keyframe [m/s]
  double acceleration_sigma = 3.0;  ///< of the mean acceleration over the window [m/s^2]

  /// The keyframe whose velocity is meant, of `keyframes`.
  static int middle(int keyframes) { return keyframes / 2; }
};

/// What is known of a window beside its data.
struct WindowPriors {
  RigPrior rig = {RigError(), {0.0, 0.0, 0.0, 0.0}};  ///< unless given, the calibration is exact
  std::optional<MotionPrior> motion = std::nullopt;
  /// In place of the priors of the biases.
  std::optional<StateFactor> known = std::nullopt;
  ImuBiases biases = {};  ///< beyond InertialOptions (assumedImuBiases())
};

}  // namespace slim_init
