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

/// Reads everything that we take from the host's file `path`, before our section: where the host
/// estimates td or the extrinsic, the standard deviations of Calibration::sigmas are raised, and
/// our section may set them otherwise. Throws a Problem (yaml_value.h).
void readHost(const cv::FileNode& root, const std::string& path, Config* config);

/// After our section was read: a rotation that is absent has to be one that is looked for. Throws a
/// Problem (yaml_value.h).
void checkExtrinsic(const Config& config);

}  // namespace slim_init::config
