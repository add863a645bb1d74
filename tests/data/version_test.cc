// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/version.h"

#include <gtest/gtest.h>

#include <string>

namespace slim_init {
namespace {

TEST(Version, MacrosAndTextAgree) {
  EXPECT_EQ(std::to_string(SLIM_INIT_VERSION_MAJOR) + "." +
                std::to_string(SLIM_INIT_VERSION_MINOR) + "." +
                std::to_string(SLIM_INIT_VERSION_PATCH),
            kVersion);
  EXPECT_GE(SLIM_INIT_VERSION_CODE, SLIM_INIT_MAKE_VERSION(0, 1, 0));
  EXPECT_LT(SLIM_INIT_VERSION_CODE,
            SLIM_INIT_MAKE_VERSION(SLIM_INIT_VERSION_MAJOR, SLIM_INIT_VERSION_MINOR + 1, 0));
}

}  // namespace
}  // namespace slim_init
