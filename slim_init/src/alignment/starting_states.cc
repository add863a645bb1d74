// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "alignment/starting_states.h"

#include <algorithm>
#include <memory>

#include "alignment/consistent_tracks.h"
#include "alignment/constants.h"
#include "alignment/gravity_constrained.h"
#include "data/with_observations.h"
#include "estimation/speed_factor.h"

namespace slim_init {
namespace {

double spreadOf(const Eigen::Matrix3Xd& centres) {
  return (centres.colwise() - centres.rowwise().mean()).norm();
}

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

WindowState stateOf(const ReverseEstimate& estimate, const std::vector<Eigen::Matrix3d>& R_b0_bk,
                    const Eigen::Vector3d& gyro_bias) {
  WindowState state;
  state.R_b0_bk = R_b0_bk;
  state.p_b0 = estimate.positions_b0;
  state.v_b0 = estimate.velocities_b0;
  state.gyro_bias = gyro_bias;
  state.accel_bias = estimate.accel_bias;
  state.gravity_b0 = estimate.gravity_b0;
  return state;
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

}  // namespace

ReverseEstimate alignTight(const LinearMotion& motion, const Eigen::Matrix3Xd& shape_b0,
                           const Eigen::MatrixXd& H_b0, int observations, double gravity_magnitude,
                           double accel_bias_prior) {
  ReverseEstimate out;
  const Eigen::Index n = shape_b0.cols();
  const double spread = spreadOf(shape_b0);
  if (!shape_b0.allFinite() || !H_b0.allFinite() || !(spread > 0.0)) return out;
  const Eigen::Map<const Eigen::VectorXd> shape(shape_b0.data(), 3 * n);
  const double lambda = shape.dot(H_b0 * shape) / (spread * spread);

  // H - lambda (I - 1 1^T / n), applied to A and c0.
  const auto centred = [n](const Eigen::MatrixXd& stacked) {
    Eigen::MatrixXd result = stacked;
    for (Eigen::Index column = 0; column < stacked.cols(); ++column) {
      Eigen::Map<Eigen::Matrix3Xd> vectors(result.col(column).data(), 3, n);
      vectors.colwise() -= vectors.rowwise().mean().eval();
    }
    return result;
  };
  const Eigen::VectorXd c0 = motion.position0 + motion.lever;
  const Eigen::MatrixXd HA = H_b0 * motion.position - lambda * centred(motion.position);
  const Eigen::Matrix<double, 9, 9> AHA = motion.position.transpose() * HA;
  const Eigen::Matrix<double, 9, 1> AHc0 = HA.transpose() * c0;

  // The weight against the bias prior needs the spread, which is part of the answer.
  Eigen::Matrix<double, 9, 1> x;
  double metres = 1.0;
  for (int pass = 0; pass < alignment_constants::kTightPasses; ++pass) {
    const double weight = observations / std::max(lambda * metres * metres, 1e-300);
    Eigen::Matrix<double, 9, 9> M = weight * AHA;
    M.diagonal().segment<3>(3).array() += 1.0 / (accel_bias_prior * accel_bias_prior);
    if (!solveGravityConstrained(M, -weight * AHc0, gravity_magnitude, &x)) return out;
    const Eigen::VectorXd c = motion.position * x + c0;
    metres = spreadOf(Eigen::Map<const Eigen::Matrix3Xd>(c.data(), 3, n));
    if (!(metres > 0.0)) return out;
  }
  out.scale = metres / spread;
  setSolution(motion, x, &out);
  return out;
}

std::vector<WindowState> startingStates(const InitWindow& window,
                                        const std::vector<Preintegration>& pre,
                                        const TranslationEstimate& translation,
                                        const SlimOptions& use,
                                        const ReverseAlignmentOptions& options,
                                        const InertialOptions& inertial) {
  const Calibration& calibration = window.calibration();
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  LinearMotion motion = linearMotion(pre, R_b0_bk, calibration.t_b_c);
  addSpeeds(window, R_b0_bk, pre.front().gyro_bias, &motion);
  const Eigen::Matrix3Xd shape_b0 = calibration.R_b_c * translation.centres_c0;
  const Eigen::MatrixXd H_b0 = rotated(translation.normal_matrix, calibration.R_b_c);
  const int observations = static_cast<int>(window.pointObservations().size());
  const Eigen::Vector3d gyro_bias = pre.front().gyro_bias;

  std::vector<WindowState> starts;
  const double lambda = std::max(translation.lambda_1, 1e-16 * translation.lambda_max);
  ReverseEstimate reverse;
  if (use.reverse_start) {
    reverse = alignReverse(motion, shape_b0, H_b0 * (observations / lambda),
                           calibration.gravity_magnitude, options, inertial.accel_bias_prior);
  }
  if (reverse.valid) {
    WindowState state = stateOf(reverse, R_b0_bk, gyro_bias);
    // From the shape, not from the IMU: the error is then in the inertial part, whose cost is
    // quadratic and corrected in one step; residuals of tens of pixels would lie on the flat part
    // of the robust loss.
    for (int k = 0; k < window.size(); ++k) {
      state.p_b0.col(k) = reverse.scale * (shape_b0.col(k) - shape_b0.col(0)) -
                          (R_b0_bk[k] * calibration.t_b_c - R_b0_bk[0] * calibration.t_b_c);
    }
    starts.push_back(state);
  }
  ReverseEstimate tight;
  if (use.tight_start) {
    tight = alignTight(motion, shape_b0, H_b0, observations, calibration.gravity_magnitude,
                       inertial.accel_bias_prior);
  }
  if (tight.valid) starts.push_back(stateOf(tight, R_b0_bk, gyro_bias));
  return starts;
}

std::vector<WindowState> consistentStartingStates(const InitWindow& window,
                                                  const std::vector<Preintegration>& pre,
                                                  const std::vector<Eigen::Matrix3d>& R_c0_ck,
                                                  const SlimOptions& use,
                                                  const AlignmentOptions& alignment,
                                                  const ReverseAlignmentOptions& reverse,
                                                  const InertialOptions& inertial) {
  const Calibration& calibration = window.calibration();
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  const std::vector<char> agrees = consistentTracks(
      window, linearMotion(pre, R_b0_bk, calibration.t_b_c), R_b0_bk, calibration.sigmaBearing(),
      calibration.gravity_magnitude, inertial.accel_bias_prior);
  std::vector<char> keep(window.pointObservations().size(), kKeepObservation);
  bool all = true;
  for (std::size_t t = 0; t < agrees.size(); ++t) {
    if (agrees[t]) continue;
    all = false;
    const Track& track = window.pointTracks()[t];
    std::fill(keep.begin() + track.begin, keep.begin() + track.end, kDropObservation);
  }
  if (all) return {};
  const std::shared_ptr<const InitWindow> agreeing = withObservations(window, keep);
  const TranslationEstimate translation = estimateTranslations(*agreeing, R_c0_ck, alignment);
  if (!translation.valid) return {};
  return startingStates(*agreeing, pre, translation, use, reverse, inertial);
}

}  // namespace slim_init
