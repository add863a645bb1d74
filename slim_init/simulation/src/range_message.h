// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sstream>
#include <string>

namespace slim_init::simulation {

/// Writes a message naming field, value and bounds when `message` is still empty and `value` is
/// outside [min, max] or not a number.
template <typename T>
void requireWithin(const char* name, T value, T min, T max, std::string* message) {
  if (!message->empty() || (value >= min && value <= max)) return;
  std::ostringstream out;
  out << name << " is " << value << ", must be in [" << min << ", " << max << "]";
  *message = out.str();
}

}  // namespace slim_init::simulation
