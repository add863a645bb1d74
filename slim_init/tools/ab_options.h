// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/report.h"
#include "slim_init/options.h"
#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/simulation/world.h"

namespace slim_init::tools {

/// The command line of `slim_init ab`. Defaults of the simulation are those of its own structs.
struct AbOptions {
  std::string recorded;  ///< directory; empty with --builtin
  std::string builtin;   ///< name of a motion; empty with --recorded
  std::string world = "room";
  std::string methods;  ///< comma separated; empty: all
  int stride = evaluation::ProtocolOptions().stride;
  int keyframes = WindowOptions().keyframes;
  int limit = 0;  ///< windows; 0: no limit
  unsigned seed = 1;
  std::string out = "out/ab";
  std::string gates = "own";
  double duration_s = 60.0;  ///< of a built-in motion
  bool quiet = false;
  simulation::FeatureSimulationOptions features;

  std::string command;  ///< as typed, for the report

  // Filled by checkAbOptions().
  std::vector<std::string> method_names;
  simulation::WorldKind world_kind = simulation::WorldKind::kRoom;
  GateMode gate_mode = GateMode::kOwn;
};

/// Declares the options on a subcommand; their ranges are checked while parsing.
void addAbOptions(CLI::App& app, AbOptions* options);

/// Checks what a single option cannot know (exactly one source, names) and fills the last fields.
/// Returns an empty string, or a sentence naming the option, its value and what is allowed.
std::string checkAbOptions(AbOptions* options);

/// The options by name, for the report.
std::vector<std::pair<std::string, evaluation::OptionValue>> describeAbOptions(
    const AbOptions& options);

}  // namespace slim_init::tools
