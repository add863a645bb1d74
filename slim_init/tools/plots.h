// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slim_init/evaluation/report.h"

namespace slim_init::tools {

/// Draws the pictures of the report in `directory` from its windows.csv, with a python3 that has
/// matplotlib, and fills info->pictures; where that is not to be had, info->picture_note says so.
void drawPlots(const std::string& directory, evaluation::RunInfo* info);

}  // namespace slim_init::tools
