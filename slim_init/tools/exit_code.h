// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace slim_init::tools {

/// What the program returns to the shell.
enum ExitCode : int {
  kExitOk = 0,
  kExitInternal = 1,  ///< our fault or the machine's: the report cannot be written
  kExitBadInput = 2,  ///< a wrong option or wrong data; the sentence on stderr says which
};

}  // namespace slim_init::tools
