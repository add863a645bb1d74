// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#define STAND_IN_FEATURE_SIZE 8
#include "host_parts.h"
