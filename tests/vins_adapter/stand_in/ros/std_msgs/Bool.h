// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

namespace std_msgs {
struct Bool {
  bool data = false;
};
typedef std::shared_ptr<const Bool> BoolConstPtr;
}  // namespace std_msgs
