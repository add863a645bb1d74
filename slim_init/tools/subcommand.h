// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The subcommands of the program: their options and what these run.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "ab_options.h"

namespace slim_init::tools {

/// What was typed.
struct Typed {
  std::string command;            ///< the whole line
  std::set<std::string> options;  ///< names, without dashes
};

struct Subcommand {
  std::string name;
  std::string help;  ///< one line
  /// Bound to fields that live as long as `run`; their values are the defaults that the help shows.
  std::vector<AbOption> options;
  /// Returns the exit code, or throws a Failure.
  std::function<int(const Typed& typed)> run;
};

/// Load or simulate a sequence, run every method on its windows, report.
Subcommand abSubcommand();
/// `slim`, `vins` and `openvins` on one recording twice, as recorded and with the errors of a
/// home-made rig, and a page.
Subcommand demoSubcommand();
/// Renders a motion through a scene and writes images, IMU data, truth and the scene itself.
Subcommand simulateSubcommand();
/// Why does an estimator not initialize on this recording? Prints a table of findings. The exit
/// code is 0 when nothing is wrong, 1 with warnings, 2 with errors; also 2 when it cannot do its
/// work (unreadable input, --json that cannot be written, out of memory), with a message on stderr,
/// so that 1 always means warnings.
Subcommand doctorSubcommand();
/// Prints every method with a line on what it is.
Subcommand methodsSubcommand();
/// Prints the keys of the section `slim_init:`, or writes config/*.yaml of a repository.
Subcommand optionsSubcommand();

}  // namespace slim_init::tools
