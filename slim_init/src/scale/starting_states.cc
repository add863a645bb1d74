// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/starting_states.h"

#include <algorithm>
#include <memory>

#include "data/with_observations.h"
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
void addSpeeds(const InitWindow& window, LinearMotion* motion) {
  const std::vector<SpeedFactor> speeds = speedFactors(window, 0.0);
  if (speeds.empty()) return;
  const std::vector<ImuInstant> instants =
      imuInstants(window, 0.0, motion->gyro_bias, Eigen::Vector3d::Zero());
  const WindowState at_zero = motion->at(Eigen::Matrix<double, 9, 1>::Zero());
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

std::optional<WindowState> startingState(const InitWindow& window,
                                         const std::vector<Preintegration>& pre,
                                         const TranslationEstimate& translation,
                                         const InertialOptions& inertial) {
  const Calibration& calibration = window.calibration();
  LinearMotion motion = linearMotion(pre, chainRotations(pre), calibration.t_b_c);
  addSpeeds(window, &motion);
  const Eigen::Matrix3Xd shape_b0 = calibration.R_b_c * translation.centres_c0;
  const Eigen::MatrixXd H_b0 = rotated(translation.normal_matrix, calibration.R_b_c);
  const int observations = static_cast<int>(window.pointObservations().size());
  const double lambda = std::max(translation.lambda_1, 1e-16 * translation.lambda_max);
  const ReverseEstimate reverse =
      alignReverse(motion, shape_b0, H_b0 * (observations / lambda), calibration.gravity_magnitude,
                   inertial.accel_bias_prior);
  if (!reverse.valid) return std::nullopt;
  WindowState state = motion.at(reverse.x);
  // From the shape, not from the IMU: the error is then in the inertial part, whose cost is
  // quadratic and corrected in one step; residuals of tens of pixels would lie on the flat part
  // of the robust loss.
  for (int k = 0; k < window.size(); ++k) {
    state.p_b0.col(k) = reverse.scale * (shape_b0.col(k) - shape_b0.col(0)) -
                        (motion.lever.segment<3>(3 * k) - motion.lever.head<3>());
  }
  return state;
}

std::optional<WindowState> inertialStartingState(const InitWindow& window,
                                                 const std::vector<Preintegration>& pre,
                                                 const InertialOptions& inertial) {
  const LinearMotion motion = linearMotion(pre, chainRotations(pre), window.calibration().t_b_c);
  const auto consistent = consistentTracks(window, motion, inertial.accel_bias_prior);
  if (!consistent) return std::nullopt;
  return motion.at(consistent->x);
}

std::optional<WindowState> consistentStartingState(const InitWindow& window,
                                                   const std::vector<Preintegration>& pre,
                                                   const InertialOptions& inertial) {
  const Calibration& calibration = window.calibration();
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  const auto consistent = consistentTracks(window, linearMotion(pre, R_b0_bk, calibration.t_b_c),
                                           inertial.accel_bias_prior);
  if (!consistent) return std::nullopt;
  std::vector<char> keep(window.pointObservations().size(), kKeepObservation);
  bool all = true;
  for (std::size_t t = 0; t < consistent->agrees.size(); ++t) {
    if (consistent->agrees[t]) continue;
    all = false;
    const Track& track = window.pointTracks()[t];
    std::fill(keep.begin() + track.begin, keep.begin() + track.end, kDropObservation);
  }
  if (all) return std::nullopt;
  const std::shared_ptr<const InitWindow> agreeing = withObservations(window, keep);
  const TranslationEstimate translation =
      estimateTranslations(*agreeing, cameraRotations(R_b0_bk, calibration.R_b_c));
  if (!translation.valid) return std::nullopt;
  return startingState(*agreeing, pre, translation, inertial);
}

}  // namespace slim_init
