// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ab_options.h"

namespace slim_init::tools {

/// What `slim_init options` prints or writes.
struct OptionsCommand {
  std::string keys = "user";  ///< user, advanced, compared or all
  std::string update;         ///< repository whose generated files are written; "" prints
};

std::vector<AbOption> optionsOptionTable(OptionsCommand* options);

/// Prints the keys of the section `slim_init:`, or writes config/*.yaml of a repository anew.
/// Returns the exit code.
int runOptions(const OptionsCommand& options);

}  // namespace slim_init::tools
