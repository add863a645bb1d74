// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include "support/folder.h"

namespace slim_init {

/// A folder of this test case alone, removed at the end.
class ScratchFolder : public Folder {
 public:
  ScratchFolder() : Folder(nameOfCase()) {}

 private:
  static std::string nameOfCase() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string("slim_init_") + info->test_suite_name() + "_" + info->name() +
                       "_" + std::to_string(getpid());
    // Parameterised tests are named "Instance/Suite": a folder of that name would stay behind.
    std::replace(name.begin(), name.end(), '/', '_');
    return name;
  }
};

inline std::string readFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace slim_init
