// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/rig_prior.h"

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
  double z2[kParts] = {};
  for (int i = 0; i < StateLayout::kRig; ++i) {
    if (!(sigma[i] > 0.0)) continue;  // held
    z2[kPartOf[i]] += e[i] * e[i] / (sigma[i] * sigma[i]);
  }
  RigPriorTerm term;
  for (const double part : z2) term.cost += gemanMcClureCost(part);
  RigVector information;
  for (int i = 0; i < StateLayout::kRig; ++i) {
    const bool held = !(sigma[i] > 0.0);
    information[i] = held ? kHold : gemanMcClure(z2[kPartOf[i]]) / (sigma[i] * sigma[i]);
    if (held) term.cost += kHold * e[i] * e[i];
  }
  RigMatrix J = RigMatrix::Identity();
  J.topLeftCorner<3, 3>() = rightJacobianInverse(e.head<3>());
  term.H = J.transpose() * information.asDiagonal() * J;
  term.g = J.transpose() * information.cwiseProduct(e);
  return term;
}

}  // namespace slim_init
