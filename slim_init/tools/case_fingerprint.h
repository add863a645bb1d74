// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "ab_options.h"

namespace slim_init::tools {

/// One line that holds all that bears on the answers of a case: the program (version, commit and
/// its very bytes), the options and the data. Equal lines, equal answers. `options` have been
/// prepared. Images are known by the table that lists them, a bag by size and time of change.
std::string caseFingerprint(const AbOptions& options);

}  // namespace slim_init::tools
