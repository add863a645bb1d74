// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ab_options.h"
#include "demo.h"
#include "doctor.h"
#include "options.h"
#include "simulate.h"

namespace slim_init::tools {

/// What the user wants.
struct CommandLine {
  std::string text;  ///< to print, if there is nothing to run: a help, the version
  /// Runs a subcommand with its part of this; returns the exit code.
  int (*run)(const CommandLine& line) = nullptr;
  AbOptions ab;
  DemoCommand demo;
  SimulateOptions simulate;
  DoctorCommand doctor;
  OptionsCommand options;
  std::vector<std::string> report;  ///< the arguments, which the Python package reads
};

/// Reads the arguments without the program's name. Returns an empty string, or a sentence naming
/// the argument at fault and what is allowed.
std::string parseCommandLine(const std::vector<std::string>& arguments, CommandLine* line);

}  // namespace slim_init::tools
