// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace std_msgs {
struct String {
  std::string data;
};
}  // namespace std_msgs
