// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/host_file.h"

#include <utility>

#include "slim_init/config/config.h"
#include "slim_init/text.h"

namespace slim_init::vins_adapter {
namespace {

HostFile toHostFile(const HostKeys& keys) {
  HostFile file;
  parseHostMode(keys.initializer, &file.mode);
  const bool shadow = file.mode == HostMode::kShadow;
  file.reinit = keys.reinit && !shadow;
  file.watchdog = keys.watchdog && !shadow;
  file.keep_heading = keys.keep_heading;
  // Shadow mode compares solves that have finished, before the host starts.
  file.max_wait_ms = shadow ? -1.0 : keys.max_wait_ms;
  file.output_path = keys.output_path;
  return file;
}

}  // namespace

bool readHostFile(const std::string& path, HostFile* file, std::string* error) {
  HostKeys keys;
  if (!loadHostKeys(path, &keys, error)) return false;
  *file = toHostFile(keys);
  return true;
}

std::unique_ptr<HostAdapter> openHostFile(const std::string& path, HostFile* file,
                                          std::string* error) {
  Config config;
  if (!loadConfig(path, &config, error)) return nullptr;
  if (config.host.num_of_cam != 1 || !config.host.imu) {
    if (error != nullptr) {
      *error = text(path, ": num_of_cam is ", config.host.num_of_cam, " and imu ", config.host.imu,
                    ", both must be 1: a host with two cameras or without IMU starts by itself");
    }
    return nullptr;
  }
  HostFile read = toHostFile(config.host);
  read.notes = config.notes;
  if (read.mode == HostMode::kShadow && (config.host.reinit || config.host.watchdog)) {
    read.notes.push_back("reinit and watchdog have no effect with initializer: shadow");
  }
  if (std::exchange(config.options.provisional.enabled, false)) {
    read.notes.push_back("provisional.enabled is set and has no effect: this host takes successes");
  }
  read.speed_topic = config.speed_topic;
  read.speed_forward_only = config.speed_forward_only;
  read.rig.calibration = config.calibration;
  read.rig.extrinsic_in_one_matrix = config.host.extrinsic_in_one_matrix;
  read.rig.has_rotation = config.host.has_rotation;
  read.rig.has_translation = config.host.has_translation;
  HostOptions options;
  options.reinit = read.reinit;
  options.watchdog = read.watchdog;
  options.max_wait_ms = read.max_wait_ms;
  options.imu = config.options.imu;
  options.estimate_td = config.estimate_td;
  options.estimate_extrinsic = config.host.estimate_extrinsic != 0;
  options.image_height = config.camera.height;
  std::unique_ptr<IInitializer> initializer = makeLiveInitializer(config, error);
  if (initializer == nullptr) return nullptr;
  std::unique_ptr<HostAdapter> adapter =
      HostAdapter::create(std::move(initializer), options, error);
  if (adapter != nullptr && file != nullptr) *file = std::move(read);
  return adapter;
}

}  // namespace slim_init::vins_adapter
