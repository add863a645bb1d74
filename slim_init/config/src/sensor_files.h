// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The sensor.yaml files of an ASL folder. Both throw a Problem (yaml_value.h).
#pragma once

#include <opencv2/core.hpp>

#include "slim_init/config/config.h"

namespace slim_init::config {

void readCameraFile(const cv::FileNode& root, Config* config);
void readImuFile(const cv::FileNode& root, Config* config);

}  // namespace slim_init::config
