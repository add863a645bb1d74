// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cctype>
#include <string>

namespace slim_init {

/// A method's name as GoogleTest allows it in the name of a test: "drt-vi-ba" becomes "DrtViBa".
inline std::string methodTestName(const ::testing::TestParamInfo<std::string>& param) {
  std::string name;
  bool upper = true;
  for (const char c : param.param) {
    if (c == '-') {
      upper = true;
      continue;
    }
    name += upper ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    upper = false;
  }
  return name;
}

}  // namespace slim_init
