// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ab_options.h"
#include "demo.h"
#include "doctor.h"
#include "options.h"
#include "simulate_options.h"

namespace slim_init::tools {

/// What the user wants.
struct CommandLine {
  enum class Action {
    kHelp,
    kVersion,
    kAb,
    kDemo,
    kSimulate,
    kDoctor,
    kReport,
    kMethods,
    kOptions
  };
  Action action = Action::kHelp;
  std::string help;                 ///< kHelp: what to print
  AbOptions ab;                     ///< kAb
  DemoCommand demo;                 ///< kDemo
  SimulateOptions simulate;         ///< kSimulate
  DoctorCommand doctor;             ///< kDoctor
  OptionsCommand options;           ///< kOptions
  std::vector<std::string> report;  ///< kReport: the arguments, which the Python package reads
};

/// Reads the arguments without the program's name. Returns an empty string, or a sentence naming
/// the argument at fault and what is allowed.
std::string parseCommandLine(const std::vector<std::string>& arguments, CommandLine* line);

}  // namespace slim_init::tools
