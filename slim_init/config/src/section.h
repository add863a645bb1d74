// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Our section `slim_init:` of a configuration file.
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "slim_init/config/config.h"

namespace slim_init::config {

/// Name of our section.
inline constexpr char kSection[] = "slim_init";

/// What was read from the files so far.
struct SectionLog {
  /// File that a key came from, by its full name ("slim_init.window.keyframes").
  std::map<std::string, std::string> origins;
  /// Earlier names that were met, with the present one.
  std::vector<RenamedKey> renamed;
};

/// Reads the section below `root` onto `config`; without one throws if it is `required`. Throws a
/// Problem (yaml_value.h) on unknown keys, wrong kinds, and two names of one key with different
/// values.
void readSection(const cv::FileNode& root, const std::string& file, bool required, Config* config,
                 SectionLog* log);

}  // namespace slim_init::config
