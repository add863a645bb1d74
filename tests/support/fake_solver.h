// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "slim_init/window_solver.h"

namespace slim_init {

/// A success on a bent path of `scale` times its true size, at these times [s].
inline InitResult bentPath(const std::vector<double>& times, double scale, double scale_sigma) {
  InitResult result;
  result.status = InitStatus::kSuccess;
  result.message = "all gates passed";
  result.gravity_w = result.gravity_b0 = Eigen::Vector3d(0.0, 0.0, -9.81);
  result.scale_sigma = scale_sigma;
  for (const double t : times) {
    NavState state;
    state.t = t;
    state.p_w_b = scale * Eigen::Vector3d(t, 2.0 * t * t, 0.0);
    state.v_w_b = scale * Eigen::Vector3d(1.0, 4.0 * t, 0.0);
    result.states.push_back(state);
  }
  GateValue gate;
  gate.name = GateName::kScaleSigma;
  gate.value = scale_sigma;
  gate.threshold = 0.1;
  gate.passed = gate.enforced = true;
  result.gates = {gate};
  return result;
}

/// Stands in for a method: answers with whatever the test says and remembers what it was shown.
/// Safe to call in parallel.
class FakeSolver : public WindowSolver {
 public:
  using Answer = std::function<InitResult(const InitWindow&)>;
  explicit FakeSolver(
      std::string name, Answer answer = [](const InitWindow& /*window*/) { return InitResult(); })
      : name_(std::move(name)), answer_(std::move(answer)) {}

  const std::string& name() const override { return name_; }
  InitResult solveWindow(const InitWindow& window, const SolveRequest& /*request*/,
                         WorkBudget* /*budget*/) const override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      windows.push_back(&window);
      times.push_back(window.times());
    }
    return answer_(window);
  }

  mutable std::vector<const InitWindow*> windows;
  mutable std::vector<std::vector<double>> times;

 private:
  std::string name_;
  Answer answer_;
  mutable std::mutex mutex_;
};

}  // namespace slim_init
