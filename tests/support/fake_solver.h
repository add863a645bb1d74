// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "slim_init/window_solver.h"

namespace slim_init {

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
