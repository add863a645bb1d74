// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The registry of all methods: `slim` and those it is compared with, written from their papers
// (docs/baselines.md). Nothing of the initializer depends on them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/baselines/options.h"
#include "slim_init/init_window.h"
#include "slim_init/initializer.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/window_solver.h"

namespace slim_init::baselines {

/// One method that can be made by name.
struct Method {
  std::string name;         ///< as on command lines and in configuration files
  std::string description;  ///< one line: what it is and its source
  /// Turns a window into a result, with valid options (WindowSolver::solve()). Null: `slim`, which
  /// makeSlimSolver() makes.
  InitResult (*solve)(const InitWindow&, const InitializerOptions&, const BaselineOptions&);
};

/// Methods that need Eigen alone, in the order in which reports list them: slim, slim-paper, drt-l,
/// drt-t, drt-vi-ba. Hosts and nodes run any of these.
const std::vector<Method>& methods();

/// methods() and those that need Ceres and OpenCV: vins, openvins. In a library of its own,
/// slim_init_ceres_baselines, which keeps both out of a host.
const std::vector<Method>& allMethods();

/// Their names.
std::vector<std::string> namesOf(const std::vector<Method>& methods);

/// Makes one of the `known` methods by name. Unknown name or invalid options: null, and a message
/// in `error` (may be null).
std::unique_ptr<WindowSolver> makeMethod(const std::string& name, const InitializerOptions& options,
                                         const BaselineOptions& baseline_options = {},
                                         std::string* error = nullptr,
                                         const std::vector<Method>& known = methods());

/// An initializer around one of methods(): makeMethod() in makeInitializer().
std::unique_ptr<IInitializer> makeInitializer(const std::string& name,
                                              const Calibration& calibration,
                                              const InitializerOptions& options,
                                              std::string* error = nullptr);

}  // namespace slim_init::baselines
