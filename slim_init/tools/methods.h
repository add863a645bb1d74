// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace slim_init::tools {

/// `slim_init methods`: prints every method with a line on what it is. Returns the exit code.
int runMethods();

}  // namespace slim_init::tools
