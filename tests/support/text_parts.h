// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <sstream>
#include <string>

namespace slim_init {

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Expects that `text` has all of `parts`, which stand with | between them.
inline void expectParts(const std::string& text, const std::string& parts) {
  std::istringstream list(parts);
  for (std::string part; std::getline(list, part, '|');) {
    EXPECT_TRUE(contains(text, part)) << "\"" << part << "\" in: " << text;
  }
}

}  // namespace slim_init
