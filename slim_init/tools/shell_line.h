// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace slim_init::tools {

/// The words as one would type them in a shell, quoted where that is needed.
std::string shellLine(const std::vector<std::string>& words);

}  // namespace slim_init::tools
