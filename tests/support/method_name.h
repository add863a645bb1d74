// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace slim_init {

/// A method's name as GoogleTest allows it in the name of a test: "drt-vi-ba" becomes "drt_vi_ba".
inline std::string methodTestName(const ::testing::TestParamInfo<std::string>& param) {
  std::string name = param.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

}  // namespace slim_init
