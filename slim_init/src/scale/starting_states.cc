// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/starting_states.h"

#include <algorithm>
#include <memory>

#include "estimation/speed_factor.h"
#include "scale/consistent_tracks.h"

namespace slim_init {
namespace {

// The normal matrix of stacked 3-vectors after a rotation of their frame.
Eigen::MatrixXd rotated(const Eigen::MatrixXd& H, const Eigen::Matrix3d& R) {
  Eigen::MatrixXd out(H.rows(), H.cols());
  for (Eigen::Index i = 0; i < H.rows(); i += 3) {
    for (Eigen::Index j = 0; j < H.cols(); j += 3) {
      out.block<3, 3>(i, j) = R * H.block<3, 3>(i, j) * R.transpose();
    }
  }
  return out;
}

// The measured velocities as a cost of x: with the shape they give the scale. A slipping wheel is
// the refinement's matter.
void addSpeeds(const InitWindow& window, const std::vector<Eigen::Matrix3d>& R_b0_bk,
               const Eigen::Vector3d& gyro_bias, LinearMotion* motion) {
  const std::vector<SpeedFactor> speeds = speedFactors(window, 0.0);
  if (speeds.empty()) return;
  const std::vector<ImuInstant> instants =
      imuInstants(window, 0.0, gyro_bias, Eigen::Vector3d::Zero());
  WindowState at_zero;
  at_zero.R_b0_bk = R_b0_bk;
  at_zero.v_b0 = Eigen::Map<const Eigen::Matrix3Xd>(motion->velocity0.data(), 3, window.size());
  for (const SpeedFactor& speed : speeds) {
    const SpeedResidual residual =
        speedResidual(at_zero, speed, window.calibration(), instants[speed.keyframe].rate);
    const Eigen::Matrix<double, 3, 9> by_x =
        residual.J.middleCols<3>(3) * motion->velocity.middleRows<3>(3 * speed.keyframe);
    motion->speed_information += by_x.transpose() * by_x;
    motion->speed_gradient -= by_x.transpose() * residual.r;
    motion->speed_cost += residual.r.squaredNorm();
  }
}

// At the poses of the IMU.
WindowState stateOf(const ReverseEstimate& estimate, const std::vector<Preintegration>& pre,
                    const std::vector<Eigen::Matrix3d>& R_b0_bk) {
  WindowState state;
  state.R_b0_bk = R_b0_bk;
  state.p_b0 = estimate.positions_b0;
  state.v_b0 = estimate.velocities_b0;
  state.gyro_bias = pre.front().gyro_bias;
  state.accel_bias = estimate.accel_bias;
  state.gravity_b0 = estimate.gravity_b0;
  return state;
}

}  // namespace

std::optional<WindowState> startingState(const InitWindow& window,
                                         const std::vector<Preintegration>& pre,
                                         const TranslationEstimate& translation,
                                         const InertialOptions& inertial) {
  const Calibration& calibration = window.calibration();
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  LinearMotion motion = linearMotion(pre, R_b0_bk, calibration.t_b_c);
  addSpeeds(window, R_b0_bk, pre.front().gyro_bias, &motion);
  const Eigen::Matrix3Xd shape_b0 = calibration.R_b_c * translation.centres_c0;
  const Eigen::MatrixXd H_b0 = rotated(translation.normal_matrix, calibration.R_b_c);
  const int observations = static_cast<int>(window.pointObservations().size());
  const double lambda = std::max(translation.lambda_1, 1e-16 * translation.lambda_max);
  const ReverseEstimate reverse =
      alignReverse(motion, shape_b0, H_b0 * (observations / lambda), calibration.gravity_magnitude,
                   inertial.accel_bias_prior);
  if (!reverse.valid) return std::nullopt;
  WindowState state = stateOf(reverse, pre, R_b0_bk);
  // From the shape, not from the IMU: the error is then in the inertial part, whose cost is
  // quadratic and corrected in one step; residuals of tens of pixels would lie on the flat part
  // of the robust loss.
  for (int k = 0; k < window.size(); ++k) {
    state.p_b0.col(k) = reverse.scale * (shape_b0.col(k) - shape_b0.col(0)) -
                        (R_b0_bk[k] * calibration.t_b_c - R_b0_bk[0] * calibration.t_b_c);
  }
  return state;
}

std::optional<WindowState> inertialStartingState(const InitWindow& window,
                                                 const std::vector<Preintegration>& pre,
                                                 const InertialOptions& inertial) {
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  const Calibration& calibration = window.calibration();
  const LinearMotion motion = linearMotion(pre, R_b0_bk, calibration.t_b_c);
  const auto x = consistentMotion(window, motion, R_b0_bk, calibration.sigmaBearing(),
                                  calibration.gravity_magnitude, inertial.accel_bias_prior);
  if (!x) return std::nullopt;
  ReverseEstimate estimate;
  setSolution(motion, *x, &estimate);
  return stateOf(estimate, pre, R_b0_bk);
}

}  // namespace slim_init
