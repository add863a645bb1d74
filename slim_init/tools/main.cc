// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// slim_init SUBCOMMAND [options]: see --help.
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "ab.h"
#include "command_line.h"
#include "demo.h"
#include "doctor.h"
#include "exit_code.h"
#include "methods.h"
#include "options.h"
#include "python_report.h"
#include "shell_line.h"
#include "simulate.h"

namespace {

using slim_init::tools::CommandLine;
using slim_init::tools::kExitBadInput;
using slim_init::tools::kExitInternal;
using slim_init::tools::kExitOk;

int run(int argc, char** argv) {
  // A caller may pass no argument at all, not even the name.
  const std::vector<std::string> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
  CommandLine line;
  if (const std::string error = slim_init::tools::parseCommandLine(arguments, &line);
      !error.empty()) {
    std::cerr << "slim_init: " << error << "\n"
              << "Run with --help for the options.\n";
    return kExitBadInput;
  }
  switch (line.action) {
    case CommandLine::Action::kHelp: std::cout << line.help; return kExitOk;
    case CommandLine::Action::kVersion:
      std::cout << "slim_init " << SLIM_INIT_VERSION << "\n";
      return kExitOk;
    case CommandLine::Action::kMethods: return slim_init::tools::runMethods();
    case CommandLine::Action::kOptions: return slim_init::tools::runOptions(line.options);
    case CommandLine::Action::kSimulate: return slim_init::tools::runSimulate(line.simulate);
    case CommandLine::Action::kDoctor: return slim_init::tools::runDoctor(line.doctor);
    case CommandLine::Action::kReport: return slim_init::tools::runReport(line.report);
    case CommandLine::Action::kDemo: return slim_init::tools::runDemo(line.demo);
    case CommandLine::Action::kAb: break;
  }
  // For the report, so that the run can be repeated by copying the line.
  std::vector<std::string> words = {"slim_init"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  line.ab.command = slim_init::tools::shellLine(words);
  return slim_init::tools::runAb(line.ab);
}

}  // namespace

int main(int argc, char** argv) {
  // Our libraries do not throw; the standard library (out of memory) and those of others may.
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "slim_init: " << error.what() << "\n";
  } catch (...) {
    std::cerr << "slim_init: an unknown error\n";
  }
  return kExitInternal;
}
