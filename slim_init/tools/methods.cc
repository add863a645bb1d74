// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "methods.h"

#include <algorithm>
#include <iomanip>
#include <iostream>
#include <map>

#include "exit_code.h"
#ifdef SLIM_INIT_HAS_BASELINES
#include "slim_init/baselines/baselines.h"
#endif

namespace slim_init::tools {
namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

const std::vector<std::string>& methodNames() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names = solverNames();
#ifdef SLIM_INIT_HAS_BASELINES
    const std::vector<std::string>& more = baselines::baselineNames();
    names.insert(names.end(), more.begin(), more.end());
#endif
    return names;
  }();
  return kNames;
}

std::unique_ptr<WindowSolver> makeMethod(const std::string& name, const InitializerOptions& options,
                                         std::string* error) {
#ifdef SLIM_INIT_HAS_BASELINES
  if (contains(baselines::baselineNames(), name)) {
    return baselines::makeBaseline(name, options, baselines::BaselineOptions(), error);
  }
#endif
  std::unique_ptr<WindowSolver> solver = makeWindowSolver(name, options, error);
  if (solver == nullptr && error != nullptr && !contains(methodNames(), name)) {
    *error = "unknown method \"" + name + "\", known are:";
    for (const std::string& known : methodNames()) *error += " " + known;
  }
  return solver;
}

int runMethods() {
  static const std::map<std::string, std::string> kDescriptions = {
      {"slim", "this project's pipeline: reverse alignment, structureless refinement, own verdict"},
      {"slim-paper", "SLIM-init as its paper writes it: points, vanishing points and lines"},
      {"drt-l", "He et al. 2023, decoupled rotation and translation, loosely coupled"},
      {"drt-t", "He et al. 2023, decoupled rotation and translation, tightly coupled"},
      {"drt-vi-ba", "Song et al. 2025, structureless visual-inertial bundle adjustment after DRT"},
      {"vins", "the structure-from-motion initializer of VINS-Mono, Qin and Shen 2017"},
      {"openvins", "the dynamic initializer of OpenVINS, Dong-Si and Mourikis 2012"},
  };
  for (const std::string& name : methodNames()) {
    const auto found = kDescriptions.find(name);
    std::cout << "  " << std::left << std::setw(12) << name
              << (found == kDescriptions.end() ? "" : found->second) << "\n";
  }
  return kExitOk;
}

}  // namespace slim_init::tools
