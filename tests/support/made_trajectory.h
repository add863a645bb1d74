// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <utility>

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

}  // namespace slim_init::simulation
