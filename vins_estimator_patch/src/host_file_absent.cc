// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// In place of host_file.cc in a build without feature_tracker_lines, which reads the files.
#include "slim_init/vins_adapter/host_file.h"

namespace slim_init::vins_adapter {
namespace {

constexpr char kWithoutOpenCv[] =
    ": this build of slim_init cannot read configuration files (install OpenCV and configure again "
    "with SLIM_INIT_BUILD_FEATURE_TRACKER_LINES=ON)";

}  // namespace

bool readHostFile(const std::string& path, HostFile* /*file*/, std::string* error) {
  if (error != nullptr) *error = path + kWithoutOpenCv;
  return false;
}

std::unique_ptr<HostAdapter> openHostFile(const std::string& path, HostFile* /*file*/,
                                          std::string* error) {
  if (error != nullptr) *error = path + kWithoutOpenCv;
  return nullptr;
}

bool readSensorsFile(const std::string& path, const Calibration& /*configured*/,
                     LearnedSensors* /*learned*/, std::string* error) {
  if (error != nullptr) *error = path + kWithoutOpenCv;
  return false;
}

bool writeSensorsFile(const std::string& path, const Calibration& /*configured*/,
                      const LearnedSensors& /*learned*/, std::string* error) {
  if (error != nullptr) *error = path + kWithoutOpenCv;
  return false;
}

}  // namespace slim_init::vins_adapter
