// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <utility>

#include "geometry/so3.h"
#include "slim_init/simulation/trajectory.h"

namespace slim_init::simulation {

/// A motion made of one function.
class MadeTrajectory : public Trajectory {
 public:
  MadeTrajectory(double begin, double end, std::function<Kinematics(double)> at)
      : begin_(begin), end_(end), at_(std::move(at)) {}
  double begin() const override { return begin_; }
  double end() const override { return end_; }
  Kinematics at(double t) const override { return at_(t); }

 private:
  double begin_, end_;
  std::function<Kinematics(double)> at_;
};

/// A motion made of position [m] and attitude; derivatives by central differences.
template <typename Position, typename Attitude>
MadeTrajectory posedTrajectory(double begin, double end, const Position& p, const Attitude& R) {
  return {begin, end, [p, R](double t) {
            constexpr double h = 1e-3;
            const Eigen::Vector3d before = p(t - h), now = p(t), after = p(t + h);
            Kinematics k;
            k.R_w_b = R(t);
            k.p_w_b = now;
            k.v_w_b = (after - before) / (2.0 * h);
            k.a_w_b = (after - 2.0 * now + before) / (h * h);
            k.omega_b = logSO3(R(t - h).transpose() * R(t + h)) / (2.0 * h);
            return k;
          }};
}

}  // namespace slim_init::simulation
