// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What a user can do about a status, for consoles.
#pragma once

#include <string>

#include "slim_init/result.h"

namespace slim_init {

/// `message` with "; " and what a user can do about `status` (docs/does_not_initialize.md);
/// `message` alone if there is nothing to do, as for a success.
std::string withRemedy(const std::string& message, InitStatus status);

}  // namespace slim_init
