// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "openvins_method.h"

#include "slim_init/baselines/baselines.h"
#include "slim_init/config/config.h"
#include "slim_init/work_budget.h"

namespace slim_init::vins_adapter {

std::unique_ptr<IInitializer> makeMethod(const std::string& file, const Calibration& rig,
                                         ImuLimits* limits, std::vector<std::string>* notes,
                                         std::string* error) {
  Config config;
  config.calibration = rig;
  if (!file.empty() && !loadOptions(file, &config, error)) return nullptr;
  *notes = config.notes;
  *limits = config.options.imu;
  config.options.limits = liveLimits(config.options.limits);
  return baselines::makeInitializer(config.method, config.calibration, config.options,
                                    config.baselines, error);
}

}  // namespace slim_init::vins_adapter
