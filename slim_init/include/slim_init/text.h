// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sstream>
#include <string>

namespace slim_init {

/// The parts of a message one after the other, numbers with `digits` significant digits; std::fixed
/// among the parts acts as in a stream.
template <typename... Parts>
std::string roundedText(int digits, const Parts&... parts) {
  std::ostringstream out;
  out.precision(digits);
  (out << ... << parts);
  return out.str();
}

/// The same with the six digits of a stream.
template <typename... Parts>
std::string text(const Parts&... parts) {
  return roundedText(6, parts...);
}

}  // namespace slim_init
