// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/starting_states.h"

#include <cmath>

#include "estimation/speed_factor.h"
#include "scale/scale_profile.h"
#include "shape/ligt.h"

namespace slim_init {
namespace {

// Standard deviation of the tracks that the search for the agreeing ones begins with, over their
// own: nearly all count. A power of two, it is halved until it is their own.
constexpr double kWidest = 256.0;

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

// What is known besides the tracks. A slipping wheel is the refinement's matter.
UnknownsPrior priorOf(const InitWindow& window, const LinearMotion& motion,
                      const InertialOptions& inertial) {
  UnknownsPrior prior;
  prior.addAccelBias(Eigen::Vector3d::Zero(), inertial.accel_bias_prior);
  const std::vector<SpeedFactor> speeds = speedFactors(window, 0.0);
  if (speeds.empty()) return prior;
  const std::vector<ImuInstant> instants =
      imuInstants(window, 0.0, motion.gyro_bias, Eigen::Vector3d::Zero());
  const WindowState at_zero = motion.at(Eigen::Matrix<double, 9, 1>::Zero());
  for (const SpeedFactor& speed : speeds) {
    const SpeedResidual residual =
        speedResidual(at_zero, speed, window.calibration(), instants[speed.keyframe].rate);
    prior.add(residual.J.middleCols<3>(3) * motion.velocity.middleRows<3>(3 * speed.keyframe),
              residual.r);
  }
  return prior;
}

}  // namespace

std::optional<WindowState> startingState(const InitWindow& window,
                                         const std::vector<Preintegration>& pre,
                                         const TranslationEstimate& translation,
                                         const InertialOptions& inertial) {
  const Calibration& calibration = window.calibration();
  const LinearMotion motion = linearMotion(pre, chainRotations(pre), calibration.t_b_c);
  Eigen::Matrix3Xd shape_b0 = calibration.R_b_c * translation.centres_c0;
  shape_b0.colwise() -= shape_b0.rowwise().mean().eval();
  const Eigen::Map<const Eigen::VectorXd> shape(shape_b0.data(), shape_b0.size());
  Eigen::MatrixXd information = rotated(translation.normal_matrix, calibration.R_b_c) *
                                (window.pointObservations().size() / translation.noise());
  information += (kLengthWeight * information.diagonal().mean()) * shape * shape.transpose();
  const ScaleCost cost(motion, shape, information, priorOf(window, motion, inertial),
                       calibration.gravity_magnitude);
  Eigen::Matrix<double, 9, 1> x;
  const double log_scale = lowestMinimum(cost).at;
  if (!std::isfinite(cost(log_scale, &x))) return std::nullopt;
  WindowState state = motion.at(x);
  // From the shape, not from the IMU: the error is then in the inertial part, whose cost is
  // quadratic and corrected in one step; residuals of tens of pixels would lie on the flat part
  // of the robust loss.
  for (int k = 0; k < window.size(); ++k) {
    state.p_b0.col(k) = std::exp(log_scale) * (shape_b0.col(k) - shape_b0.col(0)) -
                        (motion.lever.segment<3>(3 * k) - motion.lever.head<3>());
  }
  return state;
}

std::optional<WindowState> inertialStartingState(const InitWindow& window,
                                                 const std::vector<Preintegration>& pre,
                                                 const InertialOptions& inertial) {
  const Calibration& calibration = window.calibration();
  const LinearMotion motion = linearMotion(pre, chainRotations(pre), calibration.t_b_c);
  std::vector<Eigen::Matrix3d> R_b0_ck;
  for (const Eigen::Matrix3d& R_b0_b : motion.R_b0_bk)
    R_b0_ck.push_back(R_b0_b * calibration.R_b_c);
  const double sigma = calibration.sigmaBearing();
  const Eigen::VectorXd no_shape = Eigen::VectorXd::Zero(motion.lever.size());
  const UnknownsPrior prior = priorOf(window, motion, inertial);
  LengthWeights weights;
  Eigen::Matrix<double, 9, 1> x;
  for (weights.sigma = kWidest * sigma; weights.sigma >= sigma; weights.sigma *= 0.5) {
    const ScaleCost cost(motion, no_shape,
                         lengthNormalMatrix(window, R_b0_ck, weights) / (sigma * sigma), prior,
                         calibration.gravity_magnitude);
    if (!std::isfinite(cost(0.0, &x))) return std::nullopt;
    weights.centres = motion.position * x + motion.position0 + motion.lever;
  }
  return motion.at(x);
}

}  // namespace slim_init
