// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/window_solver.h"

namespace slim_init {

/// A method that has nothing but a status: what the base class says of the rest.
class PlainMethod : public WindowSolver {
 public:
  explicit PlainMethod(InitStatus status = InitResult().status) { result_.status = status; }
  const std::string& name() const override { return name_; }
  InitResult solveWindow(const InitWindow& /*window*/, const SolveRequest& /*request*/,
                         WorkBudget* /*budget*/) const override {
    return result_;
  }

 private:
  std::string name_ = "other";
  InitResult result_;
};

}  // namespace slim_init
