// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The keys of the host's own file: camera, extrinsic, time offset, tracker.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "slim_init/config/config.h"

namespace slim_init::config {

/// Reads the keys of HostKeys. Throws a Problem (yaml_value.h).
void readHostKeys(const cv::FileNode& root, HostKeys* host);

/// Reads everything that we take from the host's file `path`. Throws a Problem (yaml_value.h).
void readHost(const cv::FileNode& root, const std::string& path, Config* config);

}  // namespace slim_init::config
