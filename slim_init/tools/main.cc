// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// slim_init SUBCOMMAND [options]: see --help.
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "command_line.h"
#include "exit_code.h"

namespace {

using namespace slim_init::tools;

int run(int argc, char** argv) {
  // A caller may pass no argument at all, not even the name.
  const std::vector<std::string> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
  CommandLine line;
  if (const std::string error = parseCommandLine(arguments, &line); !error.empty()) {
    std::cerr << "slim_init: " << error << "\n"
              << "Run with --help for the options.\n";
    return kExitBadInput;
  }
  if (line.run != nullptr) return line.run();
  std::cout << line.text;
  return kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  // Our libraries do not throw; the standard library (out of memory) and those of others may.
  try {
    return run(argc, argv);
  } catch (const Failure& failure) {
    std::cerr << "slim_init: " << failure.what() << "\n";
    return failure.code;
  } catch (const std::exception& error) {
    std::cerr << "slim_init: " << error.what() << "\n";
  } catch (...) {
    std::cerr << "slim_init: an unknown error\n";
  }
  return kExitInternal;
}
