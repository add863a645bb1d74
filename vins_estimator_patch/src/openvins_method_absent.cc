// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// In place of openvins_method.cc in a build without feature_tracker_lines, which reads the files.
#include "openvins_method.h"
#include "slim_init/vins_adapter/host_adapter.h"
#include "slim_init/work_budget.h"

namespace slim_init::vins_adapter {

std::unique_ptr<IInitializer> makeMethod(const std::string& file, const Calibration& rig,
                                         ImuLimits* /*limits*/, std::vector<std::string>* /*notes*/,
                                         std::string* error) {
  InitializerOptions options = HostAdapter::hostDefaults();
  options.limits = liveLimits(options.limits);
  if (file.empty()) return makeInitializer(rig, options, error);
  *error = file + ": this build of slim_init cannot read configuration files";
  return nullptr;
}

}  // namespace slim_init::vins_adapter
