// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/report.h"
#include "slim_init/evaluation/rig_errors.h"
#include "slim_init/options.h"
#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/simulation/motion_sensors.h"
#include "slim_init/simulation/world.h"

namespace slim_init {
struct Config;  // of an optional library
}

namespace slim_init::tools {

using NamedValues = std::vector<std::pair<std::string, evaluation::OptionValue>>;

/// The command line of `slim_init ab`. Defaults of the simulation are those of its own structs.
struct AbOptions {
  // The source; exactly one of them is given.
  std::string recorded;  ///< directory of a recording without pixels
  std::string builtin;   ///< name of a motion
  std::string asl;       ///< directory of a recording with pixels
  std::string bag;       ///< file of a recording with pixels

  std::string config_file;  ///< the host's configuration file; empty: none
  std::string world = "room";
  std::string methods;       ///< comma separated; empty: all
  std::string options_file;  ///< YAML with a section `slim_init:`; empty: the defaults
  int stride = evaluation::ProtocolOptions().stride;
  std::string keyframes_text;  ///< "5..15" or "10"; empty: those of the window options
  int limit = 0;               ///< windows; 0: no limit
  int threads = evaluation::ProtocolOptions().threads;
  unsigned seed = 1;
  std::string out = "out/ab";
  std::string gates;         ///< empty: "on" for windows that grow, else "own"
  double duration_s = 60.0;  ///< of a built-in motion
  bool ablation = false;
  double downstream_s = 0.0;    ///< 0: the back end is not run
  std::string report = "auto";  ///< or "off"
  bool quiet = false;
  simulation::FeatureSimulationOptions features;
  double readout_s = 0.0;     ///< of the camera, where it was typed; else that of the calibration
  evaluation::RigErrors rig;  ///< rig.seed is `seed`
  simulation::SpeedSimulationOptions speed;  ///< in use if --speed was typed; its seed is `seed`

  /// The features come from pixels.
  bool hasImages() const { return !asl.empty() || !bag.empty(); }
  /// The camera's readout time [s] in place of that of the calibration, where it was typed.
  void setReadout(Calibration* calibration) const;
  /// A file brought options of the methods.
  bool hasFile() const { return !options_file.empty() || !config_file.empty(); }

  std::string command;          ///< as typed, for the report
  std::set<std::string> given;  ///< names of the options that were typed; they win over the file

  // Filled by readConfiguration().
  /// --config with the section of --options on top; without --config the rig is no rig's.
  std::shared_ptr<const Config> config;
  NamedValues file_values;              ///< what the file changes, by key, for the report
  std::vector<std::string> file_notes;  ///< what of the file has no effect

  // Filled by checkAbOptions().
  int keyframes = 0;
  int first_keyframes = 0;  ///< of growing windows; 0: all windows have `keyframes`
  std::vector<std::string> method_names;
  /// What every method is made with: the file's values, on top of them --keyframes and --gates.
  InitializerOptions initializer;
};

/// What an option bears on.
enum class OptionScope {
  kAlways,
  kSimulatedFeatures,  ///< no effect with --asl and --bag
  kRig,                ///< what is wrong with the rig; in the report where it was typed
};

/// One option of `slim_init ab`. Defaults are the values of a fresh AbOptions.
struct AbOption {
  std::string name;                                                   ///< without the dashes
  std::variant<bool*, std::string*, int*, unsigned*, double*> field;  ///< bool: takes no value
  std::string value_name;       ///< what stands for the value in the help
  std::string help;             ///< with the unit
  std::string report_key = {};  ///< empty: does not bear on the result
  double min = 0.0;             ///< of a number, inclusive
  double max = 0.0;
  OptionScope scope = OptionScope::kAlways;
  std::vector<std::string> choices = {};  ///< of a text; empty: any but an empty one
};

/// The parts of "a,b,c"; an empty text has none.
std::vector<std::string> splitList(const std::string& list);

bool contains(const std::vector<std::string>& names, const std::string& name);

/// All options, bound to the fields of `options`. Parsing, help, range checks and the report all go
/// through this one table.
std::vector<AbOption> abOptionTable(AbOptions* options);

/// Writes the text of the command line into the option's field. Returns an empty string, or a
/// sentence naming option, text and what is allowed.
std::string setOption(const AbOption& option, const std::string& text);

/// The present value as one would type it; empty for a switch and an empty text.
std::string valueText(const AbOption& option);

/// "1 to 100000" for a number, "auto, off" for a text with choices, else empty.
std::string rangeText(const AbOption& option);

/// Reads --config into options->config and the section `slim_init:` of --options, or else of
/// --config, into options->initializer. Says what the files change (file_values) and what of them
/// has no effect here (file_notes). Throws a Failure that names file, key, value and bound.
void readConfiguration(AbOptions* options);

/// Merges file and command line, checks what a single option cannot know (exactly one source,
/// names), and fills the last fields. Throws a Failure naming the option, its value and what is
/// allowed.
void checkAbOptions(AbOptions* options);

/// The options by name, for the report.
NamedValues describeAbOptions(const AbOptions& options);

}  // namespace slim_init::tools
