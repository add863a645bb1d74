// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/rig_model.h"

#include <algorithm>
#include <cmath>

#include "estimation/constants.h"
#include "geometry/dense.h"
#include "geometry/so3.h"

namespace slim_init {

using namespace estimation_constants;  // NOLINT: the constants of this module

namespace {
constexpr double kDegPerRad = 180.0 / M_PI;

// An error of one part of the rig along one of its independent axes. Before the data the part has a
// standard deviation t; then the variance of `off` is by_prior * t^2 + variance.
struct SeenError {
  double off = 0.0, by_prior = 1.0, variance = 0.0;
};

// Along the axes of the covariance, measured without a prior.
std::vector<SeenError> seenBy(const Eigen::VectorXd& off, const Eigen::MatrixXd& covariance,
                              double /*sigma*/) {
  const SymmetricEigen axes = symmetricEigen(covariance);
  std::vector<SeenError> seen;
  for (Eigen::Index i = 0; i < off.size(); ++i) {
    seen.push_back({axes.vectors.col(i).dot(off), 1.0, std::max(0.0, axes.values[i])});
  }
  return seen;
}

// The same of an estimate under a prior of standard deviation `sigma`, which has kept a share rho
// of its variance: what the data alone say is off / (1 - rho), with the variance sigma^2 rho / (1 -
// rho).
std::vector<SeenError> drawnBy(const Eigen::VectorXd& off, const Eigen::MatrixXd& covariance,
                               double sigma) {
  const SymmetricEigen axes = symmetricEigen(covariance / (sigma * sigma));
  std::vector<SeenError> seen;
  for (Eigen::Index i = 0; i < off.size(); ++i) {
    const double kept = std::clamp(axes.values[i], 0.0, 1.0), gone = 1.0 - kept;
    seen.push_back({axes.vectors.col(i).dot(off), gone * gone,
                    sigma * sigma * (gone * kept + kDrawnFloor * kDrawnFloor)});
  }
  return seen;
}

// -2 log of the marginal likelihood of a prior of standard deviation t.
double evidence(const std::vector<SeenError>& seen, double t) {
  double sum = 0.0;
  for (const SeenError& axis : seen) {
    const double variance = axis.by_prior * t * t + axis.variance;
    sum += std::log(variance) + axis.off * axis.off / variance;
  }
  return sum;
}

// Factor on `sigma` that the errors ask for: one where it explains them, else the upper end of the
// likely ones, so that `widest` is not exceeded.
double widening(const std::vector<SeenError>& seen, double sigma, double widest) {
  const double before = evidence(seen, sigma);
  double best = 1.0, lowest = before, upper = 1.0;
  for (double factor = kWidthStep; factor * sigma < widest * kWidthStep; factor *= kWidthStep) {
    const double here = evidence(seen, std::min(factor * sigma, widest));
    if (here < lowest) {
      lowest = here;
      best = factor;
    }
  }
  if (!(before - lowest > kContradiction)) return 1.0;
  for (upper = best; upper * sigma < widest; upper *= kWidthStep) {
    if (evidence(seen, upper * sigma) > lowest + 1.0) break;
  }
  return std::min(upper, widest / sigma);
}

// `read` makes the axes of one part of it.
template <typename Read>
CalibrationSigmas widened(const CalibrationSigmas& sigmas, const RigError& error,
                          const RigCovariance& covariance, const Read& read) {
  const auto factor = [&](const Eigen::VectorXd& off, int at, double sigma, double widest) {
    const Eigen::Index size = off.size();
    if (!(sigma > 0.0 && sigma < widest) ||
        !(covariance.diagonal().segment(at, size).minCoeff() > 0.0)) {
      return 1.0;
    }
    return widening(read(off, covariance.block(at, at, size, size), sigma), sigma, widest);
  };
  const auto scalar = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  const double rotation =
      factor(logSO3(error.dR), 0, sigmas.rotation_deg / kDegPerRad, kWideRotationDeg / kDegPerRad);
  const double translation = error.dt.norm() > kFarTranslation * sigmas.translation_m
                                 ? factor(error.dt, 3, sigmas.translation_m, kWideTranslation)
                                 : 1.0;
  const double td = factor(scalar(error.dtd), 6, sigmas.td_s, kWideTd);
  // A rig whose stamps are wrong by thirty of their standard deviations was not calibrated with the
  // care that the others speak of: one factor for rotation and td, and the lever arm follows.
  const double largest = std::max(rotation, td);
  const auto times = [](double sigma, double own, double common, double widest) {
    return std::max({sigma, own * sigma, std::min(common * sigma, widest)});
  };
  CalibrationSigmas wide = sigmas;
  wide.rotation_deg = times(sigmas.rotation_deg, rotation, largest, kWideRotationDeg);
  wide.translation_m = times(sigmas.translation_m, translation, largest, kTurnedTranslation);
  wide.td_s = times(sigmas.td_s, td, largest, kWideTd);
  return wide;
}

}  // namespace

RigError rigBetween(const RigError& reference, const RigError& error) {
  RigError out;
  out.dR = reference.dR.transpose() * error.dR;
  out.dt = error.dt - reference.dt;
  out.dtd = error.dtd - reference.dtd;
  out.dreadout = error.dreadout - reference.dreadout;
  return out;
}

CalibrationSigmas widenedByMeasurement(const CalibrationSigmas& sigmas, const RigError& error,
                                       const RigCovariance& covariance) {
  return widened(sigmas, error, covariance, seenBy);
}

CalibrationSigmas widenedByEstimate(const CalibrationSigmas& sigmas, const RigError& error,
                                    const RigCovariance& covariance) {
  return widened(sigmas, error, covariance, drawnBy);
}

std::vector<ImuInstant> imuInstants(const InitWindow& window, double td_shift,
                                    const Eigen::Vector3d& gyro_bias,
                                    const Eigen::Vector3d& accel_bias) {
  const std::vector<ImuSample>& imu = window.imu();
  std::vector<ImuInstant> instants;
  instants.reserve(window.size());
  for (const double keyframe : window.times()) {
    const double t = keyframe + td_shift;
    auto first = std::lower_bound(imu.begin(), imu.end(), t - kInstantSpan,
                                  [](const ImuSample& s, double time) { return s.t < time; });
    if (first == imu.end()) --first;
    ImuInstant sum;
    int count = 0;
    for (auto sample = first; sample != imu.end() && sample->t <= t + kInstantSpan; ++sample) {
      sum.rate += sample->gyro;
      sum.force += sample->accel;
      ++count;
    }
    if (count == 0) {
      // A slow IMU: the sample after the instant.
      sum = {first->gyro, first->accel};
      count = 1;
    }
    instants.push_back({sum.rate / count - gyro_bias, sum.force / count - accel_bias});
  }
  return instants;
}

BodyOffset::BodyOffset(const RigError& rig, const Calibration& calibration)
    : R_b_c(calibration.R_b_c * rig.dR),
      t_b_c(calibration.t_b_c + rig.dt),
      R(calibration.R_b_c * R_b_c.transpose()),
      t(calibration.t_b_c - R * t_b_c) {}

void bodyAtNominalTime(const WindowState& state, int k, const BodyOffset& offset, double td_error,
                       const ImuInstant& imu, WindowState* nominal, RigDerivatives* derivatives) {
  const Eigen::Matrix3d& R_visual = state.R_b0_bk[k];
  const Eigen::Matrix3d R_body = R_visual * offset.R;
  const Eigen::Vector3d v = state.v_b0.col(k);
  const Eigen::Vector3d acceleration = R_body * imu.force + state.gravity_b0;
  const Eigen::Matrix3d back = expSO3(-td_error * imu.rate);
  nominal->R_b0_bk[k] = R_body * back;
  nominal->p_b0.col(k) = state.p_b0.col(k) + R_visual * offset.t - td_error * v;
  nominal->v_b0.col(k) = v - td_error * acceleration;
  if (derivatives == nullptr) return;

  const double G = state.gravity_b0.norm();
  auto& by_state = derivatives->by_state;
  by_state.setZero();
  by_state.block<3, 3>(0, 0) = (offset.R * back).transpose();
  by_state.block<3, 3>(3, 0) = -R_visual * skew(offset.t);
  by_state.block<3, 3>(3, 3).setIdentity();
  by_state.block<3, 3>(3, 6).diagonal().setConstant(-td_error);
  by_state.block<3, 3>(6, 0) = td_error * R_visual * skew(offset.R * imu.force);
  by_state.block<3, 3>(6, 6).setIdentity();
  auto& by_rig = derivatives->by_rig;
  by_rig.setZero();
  by_rig.block<3, 3>(0, 0) = -back.transpose() * offset.R_b_c;
  by_rig.block<3, 3>(3, 0) = -R_body * skew(offset.t_b_c) * offset.R_b_c;
  by_rig.block<3, 3>(6, 0) = -td_error * R_body * skew(imu.force) * offset.R_b_c;
  by_rig.block<3, 3>(3, 3) = -R_body;
  by_rig.block<3, 1>(0, 6) = -imu.rate;
  by_rig.block<3, 1>(3, 6) = -v;
  by_rig.block<3, 1>(6, 6) = -acceleration;
  derivatives->by_gravity.setZero();
  derivatives->by_gravity.bottomRows<3>() = -td_error * G * tangentBasis(state.gravity_b0 / G);
}

Eigen::Matrix<double, 9, kRigInertialColumns> chainRig(
    const Eigen::Matrix<double, 9, kInertialColumns>& J, const RigDerivatives& i,
    const RigDerivatives& j) {
  // Columns of J: theta_i p_i theta_j p_j v_i v_j, then biases and gravity.
  Eigen::Matrix<double, 9, 9> J_i, J_j;
  J_i << J.middleCols<6>(0), J.middleCols<3>(12);
  J_j << J.middleCols<6>(6), J.middleCols<3>(15);
  const Eigen::Matrix<double, 9, 9> C_i = J_i.lazyProduct(i.by_state);
  const Eigen::Matrix<double, 9, 9> C_j = J_j.lazyProduct(j.by_state);
  Eigen::Matrix<double, 9, kRigInertialColumns> out;
  out.middleCols<6>(0) = C_i.leftCols<6>();
  out.middleCols<6>(6) = C_j.leftCols<6>();
  out.middleCols<3>(12) = C_i.rightCols<3>();
  out.middleCols<3>(15) = C_j.rightCols<3>();
  out.middleCols<8>(18) = J.rightCols<8>();
  out.middleCols<2>(24) += J_i.lazyProduct(i.by_gravity) + J_j.lazyProduct(j.by_gravity);
  out.rightCols<StateLayout::kRig - 1>() = J_i.lazyProduct(i.by_rig) + J_j.lazyProduct(j.by_rig);
  return out;
}

}  // namespace slim_init
