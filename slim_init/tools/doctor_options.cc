// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "doctor_options.h"

namespace slim_init::tools {

std::vector<AbOption> doctorOptionTable(DoctorCommand* command) {
  DoctorCommand& c = *command;
  return {
      {"asl", &c.asl, "DIR", "Recording in ASL layout", ""},
      {"bag", &c.bag, "FILE",
       "Recording as a bag; topics are imu_topic and image_topic of --config", ""},
      {"config", &c.config_file, "FILE",
       "The host's YAML file, to be checked; needed with --bag (default with --asl: the "
       "sensor.yaml files beside the data)",
       ""},
      {"options", &c.options_file, "FILE",
       "YAML file whose section slim_init: takes precedence over --config's", ""},
      {"limit", &c.limit, "N", "Stop after this many images (0: no limit)", "", 0, 1000000000},
      {"json", &c.json, "FILE", "Write the findings here as well, for machines", ""},
      {"quiet", &c.quiet, "", "No progress bar and no table", ""},
  };
}

std::string checkDoctorOptions(const DoctorCommand& c) {
  if (c.asl.empty() == c.bag.empty()) return "give one of --asl DIR and --bag FILE";
  if (!c.bag.empty() && c.config_file.empty()) {
    return "--bag needs --config YAML: camera, extrinsic and topics are there";
  }
  return "";
}

}  // namespace slim_init::tools
