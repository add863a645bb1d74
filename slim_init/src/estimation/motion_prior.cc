// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/motion_prior.h"

namespace slim_init {

MotionResidual motionResidual(const WindowState& state, const MotionPrior& prior, double duration) {
  const double of_speed = 1.0 / prior.speed_sigma;
  const double of_change = 1.0 / (prior.acceleration_sigma * duration);
  MotionResidual out;
  out.r.head<3>() = of_speed * state.v_b0.col(MotionPrior::middle(state.size()));
  out.r.tail<3>() = of_change * (state.v_b0.rightCols<1>() - state.v_b0.leftCols<1>());
  out.J.setZero();
  out.J.block<3, 3>(0, 3).diagonal().setConstant(of_speed);
  out.J.block<3, 3>(3, 0).diagonal().setConstant(-of_change);
  out.J.block<3, 3>(3, 6).diagonal().setConstant(of_change);
  return out;
}

}  // namespace slim_init
