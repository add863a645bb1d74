// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace slim_init::tools {

/// What the user wants.
struct CommandLine {
  std::string text;          ///< to print, if there is nothing to run: a help, the version
  std::function<int()> run;  ///< a subcommand; returns the exit code
};

/// The words as one would type them in a shell, quoted where that is needed.
std::string shellLine(const std::vector<std::string>& words);

/// Reads the arguments without the program's name. Returns an empty string, or a sentence naming
/// the argument at fault and what is allowed.
std::string parseCommandLine(const std::vector<std::string>& arguments, CommandLine* line);

}  // namespace slim_init::tools
