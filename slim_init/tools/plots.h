// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "slim_init/evaluation/report.h"

namespace slim_init::tools {

/// Draws the pictures of the report in `directory` from its windows.csv, with a python3 that has
/// matplotlib, and fills info->pictures; where that is not to be had, info->picture_note says so.
void drawPlots(const std::string& directory, evaluation::RunInfo* info);

/// Draws errors and solve times over the windows.csv of several `folders` together, as files in
/// `directory` that begin with `prefix`; `what` begins their titles. Fills `pictures` with those
/// that were drawn; returns a sentence where there are none.
std::string drawTogether(const std::string& directory, const std::string& prefix,
                         const std::vector<std::string>& folders, const std::string& what,
                         std::vector<std::pair<std::string, std::string>>* pictures);

}  // namespace slim_init::tools
