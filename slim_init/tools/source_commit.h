// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace slim_init::tools {

/// Commit that the program was configured from, abbreviated; empty where git did not know.
std::string sourceCommit();

}  // namespace slim_init::tools
