// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

namespace slim_init {

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

inline bool anyContains(const std::vector<std::string>& texts, const std::string& part) {
  return std::any_of(texts.begin(), texts.end(),
                     [&part](const std::string& text) { return contains(text, part); });
}

/// Expects that `text` has all of `parts`, which stand with | between them.
inline void expectParts(const std::string& text, const std::string& parts) {
  std::istringstream list(parts);
  for (std::string part; std::getline(list, part, '|');) {
    EXPECT_TRUE(contains(text, part)) << "\"" << part << "\" in: " << text;
  }
}

/// A matrix of a configuration file, row by row, as OpenCV has it.
inline std::string matrixKey(const std::string& key, int rows, int cols, const std::string& data) {
  return key + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
         "\n   cols: " + std::to_string(cols) + "\n   dt: d\n   data: [" + data + "]\n";
}

}  // namespace slim_init
