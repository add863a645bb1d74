// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#define STAND_IN_FEATURE_SIZE 5
#define STAND_IN_MANAGER_EXTRA    \
  struct Line {                   \
    bool is_triangulation = true; \
  };                              \
  std::list<Line> linefeature;
#include "host_parts.h"
