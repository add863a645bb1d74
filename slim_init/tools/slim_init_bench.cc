// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init_bench times`, `growth` and `count` (each with --help) print tables of whole solves, on
// simulated and on recorded motion (bench_times.h); `faults` and `soak` run a host on streams with
// faults (bench_faults.h, bench_soak.h).
#include <iostream>
#include <string>
#include <vector>

#include "bench_faults.h"
#include "bench_soak.h"
#include "bench_times.h"
#include "exit_code.h"

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const std::string command = arguments.empty() ? "" : arguments[0];
  if (slim_init::tools::isTimesCommand(arguments)) {
    return slim_init::tools::runTimesCommand(arguments);
  }
  if (command == "faults") {
    return slim_init::tools::runFaultsCommand({arguments.begin() + 1, arguments.end()});
  }
  if (command == "soak") {
    return slim_init::tools::runSoakCommand({arguments.begin() + 1, arguments.end()});
  }
  std::cerr << "slim_init_bench: '" << command
            << "' is not a command, must be one of: times, growth, count, faults, soak\n";
  return slim_init::tools::kExitBadInput;
}
