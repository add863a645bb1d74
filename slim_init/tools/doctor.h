// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ab_options.h"

namespace slim_init::tools {

/// The command line of `slim_init doctor`. Exactly one of `asl` and `bag` is given.
struct DoctorCommand {
  std::string asl;           ///< folder of the recording
  std::string bag;           ///< file of the recording
  std::string config_file;   ///< the host's configuration; empty: sensor.yaml beside the data
  std::string options_file;  ///< YAML with a section `slim_init:`; empty: that of the configuration
  int limit = 0;             ///< images; 0: all
  std::string json;          ///< file; empty: none
  bool quiet = false;
};

/// All options, bound to the fields of `command`; see abOptionTable().
std::vector<AbOption> doctorOptionTable(DoctorCommand* command);

/// `slim_init doctor`: why does an estimator not initialize on this recording? Prints a table of
/// findings. Returns 0 when nothing is wrong, 1 with warnings, 2 with errors; also 2 when it cannot
/// do its work (unreadable input, --json that cannot be written, out of memory), with a message on
/// stderr, so that 1 always means warnings.
int runDoctor(const DoctorCommand& command);

}  // namespace slim_init::tools
