// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The initializer for a host whose own files are not read by us.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/initializer.h"

namespace slim_init::vins_adapter {

/// `rig` holds where the file's section `slim_init:` is silent; "" for `file`: everywhere, and the
/// method is slim. On a problem null and a message in `error`. `limits`: of IMU samples, unchanged
/// without a file. `notes`: what a person should know.
std::unique_ptr<IInitializer> makeMethod(const std::string& file, const Calibration& rig,
                                         ImuLimits* limits, std::vector<std::string>* notes,
                                         std::string* error);

}  // namespace slim_init::vins_adapter
