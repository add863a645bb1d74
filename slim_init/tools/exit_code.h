// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace slim_init::tools {

/// What the program returns to the shell.
enum ExitCode : int {
  kExitOk = 0,
  kExitInternal = 1,  ///< our fault or the machine's: the report cannot be written
  kExitBadInput = 2,  ///< a wrong option or wrong data; the sentence on stderr says which
};

/// Ends the program with its sentence on stderr: thrown anywhere below the function of a
/// subcommand, caught by main().
struct Failure : std::runtime_error {
  Failure(ExitCode failed_with, const std::string& sentence)
      : std::runtime_error(sentence), code(failed_with) {}
  ExitCode code;
};

/// Throws a sentence, as the libraries return it, unless it is empty. `where` stands before it.
inline void check(const std::string& sentence, const std::string& where = "",
                  ExitCode code = kExitBadInput) {
  if (!sentence.empty()) throw Failure(code, where + sentence);
}

}  // namespace slim_init::tools
