// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "source_commit.h"

namespace slim_init::tools {

std::string sourceCommit() { return SLIM_INIT_COMMIT; }

}  // namespace slim_init::tools
