// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ab_options.h"

namespace slim_init::tools {

/// The command line of `slim_init tracks`.
struct TracksCommand {
  std::string asl;           ///< folder of the sequence
  std::string config_file;   ///< the host's configuration; empty: sensor.yaml beside the data
  std::string options_file;  ///< YAML with a section `slim_init:`; empty: the defaults
  int limit = 0;             ///< images; 0: all
};

/// All options, bound to the fields of `command`; see abOptionTable().
std::vector<AbOption> tracksOptionTable(TracksCommand* command);

/// `slim_init tracks`: runs the front end over the images of a sequence and prints how many
/// features it has, how long it tracks them, with a scene and ground truth how exactly, and its
/// times. Returns the exit code.
int runTracks(const TracksCommand& command);

}  // namespace slim_init::tools
