// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// An adapter from the host's own configuration file.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/host_health/calibration_lines.h"
#include "slim_init/vins_adapter/host_adapter.h"

namespace slim_init::vins_adapter {

/// Keys of the host's file besides the options of the adapter.
struct HostFile {
  HostMode mode = HostMode::kStock;
  bool reinit = false;
  bool watchdog = false;           ///< absent: as `reinit`
  bool keep_heading = false;       ///< HostGlue::keepHeading() acts; absent: as `reinit`
  std::string speed_topic;         ///< of measured velocities, or ""
  bool speed_forward_only = true;  ///< their x alone is measured
  host_health::FileCalibration rig;
  double max_wait_ms = 10.0;  ///< an image waits so long for a solve [ms]; negative: until it ends
  std::string output_path;    ///< the host's folder for results, or ""
  std::vector<std::string> notes;  ///< what a person should know
};

/// Reads `initializer`, `reinit`, `watchdog`, `keep_heading`, `max_wait_ms` and
/// `output_path` (without it GVINS' `output_dir`); absent keys are those of an unpatched host. On a
/// problem returns false, leaves `file` as it was and puts a message naming file, key, value and
/// bound into `error` (may be null).
bool readHostFile(const std::string& path, HostFile* file, std::string* error);

/// Reads the whole file and makes the adapter. Null and a message as above. `file` may be null.
std::unique_ptr<HostAdapter> openHostFile(const std::string& path, HostFile* file,
                                          std::string* error);

}  // namespace slim_init::vins_adapter
