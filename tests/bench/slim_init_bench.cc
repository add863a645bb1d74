// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// slim_init_bench COMMAND [options], each with --help. `count` solves the windows of built-in or
// recorded motion; `faults` and `soak` run a host on streams with faults (bench_commands.h).
#include <cstdio>
#include <string>
#include <vector>

#include "bench_commands.h"
#include "exit_code.h"

int main(int argc, char** argv) {
  using namespace slim_init::tools;  // NOLINT: the commands
  std::vector<std::string> arguments(argv + 1, argv + argc);
  const std::string command = arguments.empty() ? "" : arguments[0];
  if (!arguments.empty()) arguments.erase(arguments.begin());
  if (command == "count") return runCountCommand(arguments);
  if (command == "faults") return runFaultsCommand(arguments);
  if (command == "soak") return runSoakCommand(arguments);
  std::fprintf(stderr, "slim_init_bench: the command is \"%s\", must be count, faults or soak\n",
               command.c_str());
  return kExitBadInput;
}
