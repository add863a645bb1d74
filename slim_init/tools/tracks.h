// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ab_options.h"

namespace slim_init::tools {

/// The command line of `slim_init tracks`.
struct TracksOptions {
  std::string asl;           ///< folder of the sequence
  std::string config_file;   ///< the host's configuration file; empty: sensor.yaml beside the data
  std::string options_file;  ///< YAML with a section `slim_init:`; empty: the defaults
  int stride = 1;            ///< images from one that is taken to the next
  int limit = 0;             ///< images; 0: no limit
  double interval_s = 0.25;  ///< between keyframes
  std::string out;           ///< folder; empty: nothing is written
  bool quiet = false;
};

/// All options, bound to the fields of `options`; see abOptionTable().
std::vector<AbOption> tracksOptionTable(TracksOptions* options);

/// `slim_init tracks`: runs the front end over a sequence and reports how many features it tracks,
/// for how long, in what time and, where the scene is known, how accurately. Returns the exit code.
int runTracks(const TracksOptions& options);

}  // namespace slim_init::tools
