// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "methods.h"

#include <iomanip>
#include <iostream>
#include <map>
#include <string>

#include "exit_code.h"
#include "slim_init/window_solver.h"

namespace slim_init::tools {

int runMethods() {
  static const std::map<std::string, std::string> kDescriptions = {
      {"slim", "this project's pipeline: reverse alignment, structureless refinement, own verdict"},
      {"slim-paper", "SLIM-init as its paper writes it: points, vanishing points and lines"},
      {"drt-l", "He et al. 2023, decoupled rotation and translation, loosely coupled"},
      {"drt-t", "He et al. 2023, decoupled rotation and translation, tightly coupled"},
      {"drt-vi-ba", "Song et al. 2025, structureless visual-inertial bundle adjustment after DRT"},
      {"vins", "the structure-from-motion initializer of VINS-Mono, Qin et al. 2018"},
      {"openvins", "the closed-form dynamic initializer of OpenVINS, Geneva et al. 2020"},
  };
  for (const std::string& name : solverNames()) {
    const auto found = kDescriptions.find(name);
    std::cout << "  " << std::left << std::setw(12) << name
              << (found == kDescriptions.end() ? "" : found->second) << "\n";
  }
  return kExitOk;
}

}  // namespace slim_init::tools
