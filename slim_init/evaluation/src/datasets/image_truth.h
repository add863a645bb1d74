// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace slim_init::evaluation {

/// "FILE: 2 IMU samples repeat a stamp and were dropped, ..." or an empty string.
std::string disorderNote(const std::string& source, const std::string& things, int repeated,
                         int out_of_order);

}  // namespace slim_init::evaluation
