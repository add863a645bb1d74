// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/window_solver.h"

namespace slim_init {

/// A method that has nothing but solve(): what the base class says of the rest.
class PlainMethod : public WindowSolver {
 public:
  const std::string& name() const override { return name_; }
  InitResult solve(const InitWindow& /*window*/) const override { return InitResult(); }

 private:
  std::string name_ = "other";
};

}  // namespace slim_init
