// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "priors/sensor_priors.h"

#include <cmath>

#include "geometry/robust.h"
#include "geometry/so3.h"
#include "geometry/units.h"

namespace slim_init {

RigPriorTerm rigPriorTerm(const RigPrior& prior, const RigError& rig) {
  RigVector sigma;
  sigma << Eigen::Vector3d::Constant(prior.sigmas.rotation_deg / kDegPerRad),
      Eigen::Vector3d::Constant(prior.sigmas.translation_m), prior.sigmas.td_s,
      prior.sigmas.readout_s;
  RigVector e;
  e << logSO3(prior.mean.dR.transpose() * rig.dR), rig.dt - prior.mean.dt, rig.dtd - prior.mean.dtd,
      rig.dreadout - prior.mean.dreadout;

  enum Part { kRotationAndTd, kLeverArm, kReadout, kParts };
  constexpr Part kPartOf[StateLayout::kRig] = {kRotationAndTd, kRotationAndTd, kRotationAndTd,
                                               kLeverArm,      kLeverArm,      kLeverArm,
                                               kRotationAndTd, kReadout};
  RigPriorTerm term;
  RigVector information;
  double z2[kParts] = {};
  for (int i = 0; i < StateLayout::kRig; ++i) {
    const bool held = !(sigma[i] > 0.0);
    information[i] = held ? kHold : 1.0 / (sigma[i] * sigma[i]);
    (held ? term.cost : z2[kPartOf[i]]) += information[i] * e[i] * e[i];
  }
  for (const double part : z2) term.cost += gemanMcClureCost(part);
  for (int i = 0; i < StateLayout::kRig; ++i) {
    if (sigma[i] > 0.0) information[i] *= gemanMcClure(z2[kPartOf[i]]);
  }
  RigMatrix J = RigMatrix::Identity();
  J.topLeftCorner<3, 3>() = rightJacobianInverse(e.head<3>());
  term.H = J.transpose() * information.asDiagonal() * J;
  term.g = J.transpose() * information.cwiseProduct(e);
  return term;
}

bool areKnown(const ImuBiases& biases, const InertialOptions& options) {
  return biases.gyro_sigma < options.gyro_bias_prior ||
         biases.accel_sigma < options.accel_bias_prior;
}

ImuBiases assumedImuBiases(const ImuBiases& known, const InertialOptions& options) {
  ImuBiases out = known;
  if (!(known.gyro_sigma < options.gyro_bias_prior)) {
    out.gyro.setZero();
    out.gyro_sigma = options.gyro_bias_prior;
  }
  if (!(known.accel_sigma < options.accel_bias_prior)) {
    out.accel.setZero();
    out.accel_sigma = options.accel_bias_prior;
  }
  return out;
}

AccelBiasTerm accelBiasTerm(const ImuBiases& known, const InertialOptions& options,
                            const Eigen::Vector3d& accel_bias) {
  const ImuBiases prior = assumedImuBiases(known, options);
  const double z2 = (accel_bias - prior.accel).squaredNorm() / std::pow(prior.accel_sigma, 2);
  if (prior.accel_sigma < options.accel_bias_prior) return {z2, prior.accel_sigma};
  constexpr double kDegrees = 2.0 + 3.0;  // of freedom, and components
  const double excess = 1.0 + z2 / kDegrees;
  return {kDegrees * std::log(excess), prior.accel_sigma * std::sqrt(excess)};
}

}  // namespace slim_init
