// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/report.h"
#include "slim_init/options.h"
#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/simulation/world.h"

namespace slim_init::tools {

using NamedValues = std::vector<std::pair<std::string, evaluation::OptionValue>>;

/// The command line of `slim_init ab`. Defaults of the simulation are those of its own structs.
struct AbOptions {
  std::string recorded;  ///< directory; empty with --builtin
  std::string builtin;   ///< name of a motion; empty with --recorded
  std::string world = "room";
  std::string methods;       ///< comma separated; empty: all
  std::string options_file;  ///< YAML with a section `slim_init:`; empty: the defaults
  int stride = evaluation::ProtocolOptions().stride;
  int keyframes = WindowOptions().keyframes;
  int limit = 0;  ///< windows; 0: no limit
  unsigned seed = 1;
  std::string out = "out/ab";
  std::string gates = "own";
  double duration_s = 60.0;  ///< of a built-in motion
  bool quiet = false;
  simulation::FeatureSimulationOptions features;

  std::string command;          ///< as typed, for the report
  std::set<std::string> given;  ///< names of the options that were typed; they win over the file

  // Filled by readOptionsFile() when there is a file.
  NamedValues file_values;              ///< what the file changes, by key, for the report
  std::vector<std::string> file_notes;  ///< what of the file has no effect

  // Filled by checkAbOptions().
  std::vector<std::string> method_names;
  simulation::WorldKind world_kind = simulation::WorldKind::kRoom;
  /// What every method is made with: the file's values, on top of them --keyframes and --gates.
  InitializerOptions initializer;
};

/// One option of `slim_init ab`. Defaults are the values of a fresh AbOptions.
struct AbOption {
  std::string name;                                                   ///< without the dashes
  std::variant<bool*, std::string*, int*, unsigned*, double*> field;  ///< bool: takes no value
  std::string value_name;  ///< what stands for the value in the help
  std::string help;        ///< with the unit
  std::string report_key;  ///< empty: does not bear on the result
  double min = 0.0;        ///< of a number, inclusive
  double max = 0.0;
};

/// All options, bound to the fields of `options`. Parsing, help, range checks and the report all go
/// through this one table.
std::vector<AbOption> abOptionTable(AbOptions* options);

/// Writes the text of the command line into the option's field. Returns an empty string, or a
/// sentence naming option, text and bound.
std::string setOption(const AbOption& option, const std::string& text);

/// The present value as one would type it; empty for a switch and an empty text.
std::string valueText(const AbOption& option);

/// "1 to 100000" for a number, else empty.
std::string rangeText(const AbOption& option);

/// Merges file and command line, checks ranges and what a single option cannot know (exactly one
/// source, names), and fills the last fields. Returns an empty string, or a sentence naming the
/// option, its value and what is allowed.
std::string checkAbOptions(AbOptions* options);

/// The options by name, for the report.
NamedValues describeAbOptions(const AbOptions& options);

}  // namespace slim_init::tools
