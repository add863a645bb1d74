// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Our section `slim_init:` of a configuration file.
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "slim_init/config/config.h"

namespace slim_init::config {

/// Name of our section.
inline constexpr char kSection[] = "slim_init";

/// What was read from the files so far: the file that a key came from, by its full name
/// ("slim_init.window.keyframes").
using SectionLog = std::map<std::string, std::string>;

/// Reads the section below `root` onto `config`; without one throws if it is `required`. Throws a
/// Problem (yaml_value.h) on unknown keys, wrong kinds, and a key that is given twice.
void readSection(const cv::FileNode& root, const std::string& file, bool required, Config* config,
                 SectionLog* log);

}  // namespace slim_init::config
