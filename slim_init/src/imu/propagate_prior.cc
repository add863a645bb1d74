// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/propagate_prior.h"

#include "geometry/so3.h"
#include "imu/preintegration.h"

namespace slim_init {
namespace {

// A sensor in motion against its data sheet: three times what recorded flights show over windows
// (docs/derivation.md, 4.2), since here nothing measures it.
constexpr double kInMotion = 10.0;

constexpr int kTheta = 0, kPosition = 3, kVelocity = 6, kGyroBias = 9, kAccelBias = 12;

}  // namespace

StatePrior propagatePrior(const StatePrior& prior, double t, const std::vector<ImuSample>& samples,
                          double gravity_magnitude, const ImuNoise& noise) {
  if (!(t > prior.state.t)) return prior;
  ImuNoise in_motion = noise;
  in_motion.gyro_density *= kInMotion;
  in_motion.accel_density *= kInMotion;
  const NavState& from = prior.state;
  const Preintegration pre = preintegrate(samples, from.t, t, {from.gyro_bias, from.accel_bias},
                                          in_motion, PreintegrationParts::kWithCovariance);
  StatePrior carried = prior;
  carried.state = propagate(from, pre, Eigen::Vector3d(0.0, 0.0, -gravity_magnitude));
  const Eigen::Matrix3d& R = from.R_w_b;
  Eigen::Matrix<double, 15, 15> F = Eigen::Matrix<double, 15, 15>::Identity();
  F.block<3, 3>(kTheta, kTheta) = pre.dR.transpose();
  F.block<3, 3>(kTheta, kGyroBias) = pre.dR_dbg;
  F.block<3, 3>(kVelocity, kTheta) = -R * skew(pre.dv);
  F.block<3, 3>(kVelocity, kGyroBias) = R * pre.dv_dbg;
  F.block<3, 3>(kVelocity, kAccelBias) = R * pre.dv_dba;
  F.block<3, 3>(kPosition, kTheta) = -R * skew(pre.dp);
  F.block<3, 3>(kPosition, kVelocity).diagonal().setConstant(pre.dt);
  F.block<3, 3>(kPosition, kGyroBias) = R * pre.dp_dbg;
  F.block<3, 3>(kPosition, kAccelBias) = R * pre.dp_dba;
  // The preintegration's errors are [theta, v, p], the last two in the first body.
  Eigen::Matrix<double, 15, 9> G = Eigen::Matrix<double, 15, 9>::Zero();
  G.block<3, 3>(kTheta, 0).setIdentity();
  G.block<3, 3>(kVelocity, 3) = R;
  G.block<3, 3>(kPosition, 6) = R;
  carried.covariance = F * prior.covariance * F.transpose() + G * pre.covariance * G.transpose();
  return carried;
}

}  // namespace slim_init
