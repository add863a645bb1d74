// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// slim_init SUBCOMMAND [options]: see --help.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <string>

#include "ab.h"
#include "exit_code.h"
#include "methods.h"

namespace {

using slim_init::tools::AbOptions;
using slim_init::tools::kExitBadInput;
using slim_init::tools::kExitInternal;
using slim_init::tools::kExitOk;

// For the report, so that the run can be repeated by copying the line.
std::string commandLine(int argc, char** argv) {
  std::string line;
  for (int i = 0; i < argc; ++i) {
    const std::string argument = i == 0 ? "slim_init" : argv[i];
    const bool plain = !argument.empty() &&
                       argument.find_first_of(" \t\n'\"\\$`*?&;|<>()[]#~!") == std::string::npos;
    if (i > 0) line += ' ';
    if (plain) {
      line += argument;
      continue;
    }
    line += '\'';
    for (const char c : argument) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

int run(int argc, char** argv) {
  CLI::App app("Drop-in visual-inertial initialization: evaluation tools", "slim_init");
  app.require_subcommand(0, 1);
  bool version = false;
  app.add_flag("--version", version, "Print the version and exit");
  AbOptions ab_options;
  CLI::App* ab = app.add_subcommand("ab", "Compare initializers on identical windows");
  slim_init::tools::addAbOptions(*ab, &ab_options);
  CLI::App* methods = app.add_subcommand("methods", "List the methods with a line each");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // --help is an "error" with exit code 0.
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "slim_init: " << error.what() << "\n"
              << "Run with --help for the options.\n";
    return kExitBadInput;
  }
  if (version) {
    std::cout << "slim_init " << SLIM_INIT_VERSION << "\n";
    return kExitOk;
  }
  if (ab->parsed()) {
    ab_options.command = commandLine(argc, argv);
    return slim_init::tools::runAb(ab_options);
  }
  if (methods->parsed()) return slim_init::tools::runMethods();
  std::cerr << "slim_init: a subcommand is needed\n" << app.help();
  return kExitBadInput;
}

}  // namespace

int main(int argc, char** argv) {
  // Our libraries do not throw; the standard library may (out of memory).
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "slim_init: " << error.what() << "\n";
    return kExitInternal;
  }
}
