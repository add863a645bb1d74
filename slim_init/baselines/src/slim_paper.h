// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/baselines/options.h"
#include "slim_init/window_solver.h"

namespace slim_init::baselines {

/// `slim-paper`: SLIM-init as written in section IV of the paper, each term with its switch
/// (SlimPaperOptions). With all switches off it differs from drt-l in the robust cost of step 1
/// only. What its line terms are worth: docs/method_slim_paper.md.
class SlimPaper : public WindowSolver {
 public:
  SlimPaper(const InitializerOptions& options, const BaselineOptions& baseline_options)
      : options_(options), baseline_options_(baseline_options) {}
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;

 private:
  InitializerOptions options_;
  BaselineOptions baseline_options_;
};

}  // namespace slim_init::baselines
