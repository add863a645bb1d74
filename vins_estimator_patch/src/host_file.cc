// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/host_file.h"

#include <utility>

#include "slim_init/feature_tracker_lines/config.h"

namespace slim_init::vins_adapter {
namespace {

HostFile toHostFile(const feature_tracker_lines::HostKeys& keys) {
  HostFile file;
  parseHostMode(keys.initializer, &file.mode);
  file.reinit = keys.reinit;
  file.output_path = keys.output_path;
  return file;
}

}  // namespace

bool readHostFile(const std::string& path, HostFile* file, std::string* error) {
  feature_tracker_lines::HostKeys keys;
  if (!feature_tracker_lines::loadHostKeys(path, &keys, error)) return false;
  *file = toHostFile(keys);
  return true;
}

std::unique_ptr<HostAdapter> openHostFile(const std::string& path, HostFile* file,
                                          std::string* error) {
  feature_tracker_lines::Config config;
  if (!feature_tracker_lines::loadConfig(path, HostAdapter::hostDefaults(), &config, error)) {
    return nullptr;
  }
  if (config.host.estimate_extrinsic == 2) {
    if (error != nullptr) {
      *error = path +
               ": estimate_extrinsic is 2, must be 0 or 1: the initializer has to know "
               "how the camera sits on the IMU";
    }
    return nullptr;
  }
  HostFile read = toHostFile(config.host);
  read.notes = config.notes;
  HostOptions options;
  options.mode = read.mode;
  options.reinit = read.reinit;
  options.imu = config.imu_limits;
  std::unique_ptr<HostAdapter> adapter =
      HostAdapter::create(config.method, config.calibration, config.options, options, error);
  if (adapter != nullptr && file != nullptr) *file = std::move(read);
  return adapter;
}

}  // namespace slim_init::vins_adapter
