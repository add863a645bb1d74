// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A rig held in the hand and shaken about all axes, or standing.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "geometry/so3.h"
#include "slim_init/simulation/trajectory.h"
#include "slim_init/types.h"

namespace slim_init {

/// Smooth and known exactly; derivatives by central differences.
class Handheld : public simulation::Trajectory {
 public:
  double duration_s = 10.0;
  Eigen::Vector3d turning = Eigen::Vector3d(0.15, 0.2, 0.25);  ///< amplitudes about b [rad]
  double moving = 1.0;                                         ///< factor on the path

  double begin() const override { return 0.0; }
  double end() const override { return duration_s; }
  simulation::Kinematics at(double t) const override {
    constexpr double kStep = 1e-3;
    simulation::Kinematics k;
    k.R_w_b = attitude(t);
    k.p_w_b = position(t);
    k.v_w_b = (position(t + kStep) - position(t - kStep)) / (2.0 * kStep);
    k.a_w_b = (position(t + kStep) - 2.0 * position(t) + position(t - kStep)) / (kStep * kStep);
    k.omega_b = logSO3(attitude(t - kStep).transpose() * attitude(t + kStep)) / (2.0 * kStep);
    return k;
  }

 private:
  Eigen::Matrix3d attitude(double t) const {
    return expSO3(Eigen::Vector3d(turning.x() * std::sin(4.1 * t),
                                  turning.y() * std::sin(3.3 * t + 1.0),
                                  turning.z() * std::sin(2.6 * t + 2.0)));
  }
  Eigen::Vector3d position(double t) const {
    return moving * Eigen::Vector3d(0.2 * std::sin(1.9 * t), 0.25 * std::sin(2.3 * t + 0.5),
                                    0.15 * std::sin(2.9 * t + 1.5));
  }
};

/// The camera looks along x of the body, slightly askew as real ones are mounted.
inline Eigen::Matrix3d handheldExtrinsic() {
  Eigen::Matrix3d R_b_c;
  R_b_c << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R_b_c * expSO3(Eigen::Vector3d(0.03, -0.02, 0.01));
}

}  // namespace slim_init
