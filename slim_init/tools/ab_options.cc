// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "ab_options.h"

#include <algorithm>
#include <boost/algorithm/string/join.hpp>
#include <boost/lexical_cast/try_lexical_convert.hpp>
#include <cstdint>
#include <limits>
#include <sstream>
#include <type_traits>

#include "exit_code.h"
#include "methods.h"
#include "slim_init/simulation/trajectory.h"
#include "slim_init/text.h"

namespace slim_init::tools {

using boost::algorithm::join;

std::vector<std::string> splitList(const std::string& list) {
  std::vector<std::string> parts;
  std::istringstream stream(list.empty() ? "" : list + ",");
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

namespace {

// What a field pointer of the table points to.
template <typename Pointer>
using Pointee = std::remove_pointer_t<Pointer>;

template <typename T>
constexpr bool kIsNumber = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

// The largest seed has ten digits.
std::string numberText(double value) { return roundedText(10, value); }

/// "a whole number in [1, 100000]"
template <typename T>
std::string allowedText(const AbOption& option) {
  return std::string(std::is_integral_v<T> ? "a whole number" : "a number") + " in [" +
         numberText(option.min) + ", " + numberText(option.max) + "]";
}

/// Reads all of `text` as a number in [min, max].
template <typename T>
bool readNumber(const std::string& text, double min, double max, T* value) {
  std::conditional_t<std::is_integral_v<T>, std::int64_t, double> number = 0;
  const bool is_number = boost::conversion::try_lexical_convert(text, number);
  if (!is_number || !(number >= min && number <= max)) return false;  // no NaN
  *value = static_cast<T>(number);
  return true;
}

constexpr int kMaxKeyframes = 15;

constexpr std::pair<const char*, GateMode> kGateModes[] = {
    {"own", GateMode::kOwn}, {"on", GateMode::kOn}, {"off", GateMode::kOff}};

void checkMethods(AbOptions* options) {
  options->method_names.clear();
  if (options->methods.empty()) options->method_names = methodNames();
  for (const std::string& name : splitList(options->methods)) {
    if (!contains(methodNames(), name)) {
      check("--methods names '" + name + "', must be one of: " + join(methodNames(), ", "));
    }
    if (contains(options->method_names, name)) check("--methods names '" + name + "' twice");
    options->method_names.push_back(name);
  }
}

bool typed(const AbOptions& options, const char* name) { return options.given.count(name) > 0; }

/// "10", or "4..15" for expanding windows.
void checkKeyframes(AbOptions* options) {
  const auto read = [](const std::string& text, int* value) {
    const AbOption range = {"keyframes", value, "", "", "", kMinKeyframes, kMaxKeyframes};
    check(setOption(range, text));
  };
  options->first_keyframes = 0;
  const std::string& text = options->keyframes_text;
  const std::size_t dots = text.find("..");
  if (dots == std::string::npos) return read(text, &options->keyframes);
  read(text.substr(0, dots), &options->first_keyframes);
  read(text.substr(dots + 2), &options->keyframes);
  if (options->first_keyframes >= options->keyframes) {
    check("--keyframes: '" + text + "' must expand, as 4..15 does");
  }
}

/// The file a value of the methods' options came from.
std::string fileOfOptions(const AbOptions& options) {
  return options.options_file.empty() ? "--config: " + options.config_file
                                      : "--options: " + options.options_file;
}

/// Keyframes of a window. What was not typed is as in the options, those of a file included;
/// windows of one size are the paper's.
void mergeWindow(AbOptions* options) {
  AbOptions& o = *options;
  WindowOptions& window = o.initializer.window;
  const bool typed_keyframes = typed(o, "keyframes");
  if (!typed_keyframes) {
    o.keyframes_text =
        std::to_string(window.min_keyframes) + ".." + std::to_string(window.keyframes);
    if (window.min_keyframes == window.keyframes)
      o.keyframes_text = std::to_string(window.keyframes);
  }
  // The bounds of the options are wider.
  if (!typed_keyframes && (window.keyframes < kMinKeyframes || window.keyframes > kMaxKeyframes)) {
    check(text(fileOfOptions(o), ": slim_init.window.keyframes is ", window.keyframes,
               ", must be a whole number in [", kMinKeyframes, ", ", kMaxKeyframes, "]"));
  }
  checkKeyframes(options);
  const bool growing = o.first_keyframes > 0;
  if (!growing && typed_keyframes) {
    window.min_interval_s = evaluation::paperWindow().min_interval_s;
    window.max_span_s = evaluation::paperWindow().max_span_s;
  }
  window.keyframes = o.keyframes;
  window.min_keyframes = growing ? o.first_keyframes : o.keyframes;
  // The window that the options were made for may be short; the protocol keeps what it needs.
  window.buffer_s = std::max(window.buffer_s, 2.0 * window.fullSpan() + 1.0);
}

/// Where --keyframes and --gates were not typed, the file's values become theirs, for the report.
void mergeFile(AbOptions* options) {
  AbOptions& o = *options;
  mergeWindow(options);
  if (!typed(o, "gates") && (!o.hasFile() || o.initializer.gates.mode == GateMode::kOwn)) {
    o.gates = o.first_keyframes > 0 ? "on" : "own";
  }
  const bool from_file = o.gates.empty();
  for (const auto& [name, mode] : kGateModes) {
    if (from_file && o.initializer.gates.mode == mode) o.gates = name;
    if (!from_file && o.gates == name) o.initializer.gates.mode = mode;
  }
}

/// Exactly one source, and nothing that has no effect with it.
void checkSource(const AbOptions& options) {
  AbOptions o = options;  // the table binds to fields that can be written
  std::vector<std::string> sources;
  for (const auto& [name, value] :
       {std::make_pair("--asl", o.asl), std::make_pair("--bag", o.bag),
        std::make_pair("--recorded", o.recorded), std::make_pair("--builtin", o.builtin)}) {
    if (!value.empty()) sources.emplace_back(name);
  }
  if (sources.empty()) {
    check("one of --asl DIR, --bag FILE, --recorded DIR and --builtin NAME is needed");
  }
  if (sources.size() > 1) check(sources[0] + " and " + sources[1] + " exclude each other");
  for (const AbOption& option : abOptionTable(&o)) {
    if (!typed(o, option.name.c_str())) continue;
    // A seed is that of the rig's errors as well.
    if (option.name == "seed" && o.rig.any()) continue;
    const bool of_builtin = option.name == "duration" && o.builtin.empty();
    if (of_builtin || (o.hasImages() && option.scope == OptionScope::kSimulatedFeatures)) {
      check("--" + option.name + " has no effect with " + sources[0]);
    }
  }
  if (o.rig.random && o.rig.td_s == 0.0 && o.rig.extrinsic_deg == 0.0) {
    check("--random-rig has no effect without --td-error or --extrinsic-error");
  }
  if (!o.bag.empty() && o.config_file.empty()) {
    check("--bag needs --config YAML, which holds the calibration and names the topics");
  }
}

}  // namespace

void AbOptions::setReadout(Calibration* calibration) const {
  if (given.count("readout") > 0) calibration->readout_s = readout_s;
}

std::vector<AbOption> abOptionTable(AbOptions* options) {
  AbOptions& o = *options;
  simulation::FeatureSimulationOptions& f = o.features;
  constexpr double kMaxSeed = std::numeric_limits<unsigned>::max();
  constexpr OptionScope kSimulated = OptionScope::kSimulatedFeatures;
  constexpr OptionScope kRig = OptionScope::kRig;
  using Choices = std::vector<std::string>;
  const Choices gates = {"own", "on", "off"}, reports = {"auto", "off"};
  return {
      {"asl", &o.asl, "DIR",
       "Recording with images: ASL folder (EuRoC's layout), DIR/mav0 or DIR with cam0 and imu0",
       "asl"},
      {"bag", &o.bag, "FILE",
       "Recording with images: bag of ROS 1; needs --config, which names the topics; ground truth, "
       "8 "
       "or 17 columns, from FILE.groundtruth.csv",
       "bag"},
      {"config", &o.config_file, "YAML",
       "The host's configuration file (VINS-Mono's, as it is): camera, extrinsic, td, topics and "
       "the section slim_init:",
       "config"},
      {"recorded", &o.recorded, "DIR",
       "Folder with imu0.csv, cam0_timestamps.csv, groundtruth.csv: real IMU data, features "
       "simulated along the ground-truth trajectory",
       "recorded"},
      {"builtin", &o.builtin, "NAME", "Simulated motion", "builtin", 0.0, 0.0, OptionScope::kAlways,
       simulation::builtinTrajectoryNames()},
      {"duration", &o.duration_s, "X", "Length of a built-in motion [s]", "duration_s", 3.0, 3600.0,
       kSimulated},
      {"world", &o.world, "NAME", "Scene", "world", 0.0, 0.0, kSimulated, simulation::worldNames()},
      {"methods", &o.methods, "LIST",
       "Methods, comma separated: " + join(methodNames(), ", ") + " (default: all)", "methods"},
      {"options", &o.options_file, "FILE",
       "YAML file with a section slim_init: for every method (`slim_init options` lists the keys); "
       "wins over --config",
       "options"},
      {"gates", &o.gates, "MODE",
       "Whose gates decide: own (as published), on or off for every method; wins over --options "
       "(default: on with expanding windows, else own)",
       "gates", 0.0, 0.0, OptionScope::kAlways, gates},
      {"seed", &o.seed, "N", "Seed of everything random; equal seeds give equal windows", "seed",
       0.0, kMaxSeed, kSimulated},
      {"stride", &o.stride, "N", "Images between the starts of two windows", "stride", 1, 100000},
      {"keyframes", &o.keyframes_text, "N",
       "A..B: windows expand from A to B keyframes (4 to 15) and are solved at every image until "
       "the method accepts; N: windows of N keyframes, 10 as in the paper, at least 0.22 s apart "
       "(default: 5..15, or as in the files)",
       "keyframes"},
      {"limit", &o.limit, "N", "Stop after this many windows (0: no limit)", "limit", 0,
       1000000000},
      {"threads", &o.threads, "N",
       "Windows solved at the same time; estimates do not depend on it, wall times do", "", 1,
       evaluation::kMaxThreads},
      {"points", &f.max_points, "N", "Points tracked in one image", "points", 0, 2000, kSimulated},
      {"lines", &f.max_lines, "N", "Lines tracked in one image", "lines", 0, 500, kSimulated},
      {"pixel-noise", &f.pixel_noise, "X", "Noise of a point, per axis [px]", "pixel_noise", 0.0,
       10.0, kSimulated},
      {"drift", &f.drift, "X", "Random walk of a point track, per image and axis [px]", "drift",
       0.0, 10.0, kSimulated},
      {"outliers", &f.outlier_rate, "X", "Fraction of point tracks that slide off", "outliers", 0.0,
       1.0, kSimulated},
      {"speed", &o.speed.noise, "X",
       "Simulated forward speed at 50 Hz, half a metre behind the body: its noise as a fraction of "
       "the speed, at least 0.01 m/s",
       "speed_noise", 0.0, 1.0, kSimulated},
      {"td-error", &o.rig.td_s, "S", "Injected td error [s]: td_given = td_true - S", "td_error_s",
       -0.5, 0.5, kRig},
      {"extrinsic-error", &o.rig.extrinsic_deg, "DEG",
       "Injected error of the extrinsic rotation [deg], about an axis drawn from the seed",
       "extrinsic_error_deg", 0.0, 180.0, kRig},
      {"random-rig", &o.rig.random, "",
       "Per window a td error of up to +- --td-error and a rotation error of up to "
       "--extrinsic-error, uniform, about an axis of its own",
       "random_rig", 0.0, 0.0, kRig},
      {"readout", &o.readout_s, "S",
       "Rolling shutter: time from the first row to the last [s]; simulated, or what the camera of "
       "the images has (default: that of the calibration)",
       "readout_s", 0.0, 0.1, kRig},
      {"readout-error", &o.rig.readout_s, "S",
       "Injected error of the readout time [s]: readout_given = readout_true + S; "
       "minus that of --readout: an undeclared rolling shutter",
       "readout_error_s", -0.1, 0.1, kRig},
      {"imu-rate", &o.rig.imu_rate_hz, "HZ",
       "IMU at a lower rate, each sample the mean over its interval [Hz]", "imu_rate_hz", 25.0,
       10000.0, kRig},
      {"imu-jitter", &o.rig.imu_jitter_s, "S",
       "Standard deviation of the IMU's stamps, cut off at 0.45 intervals [s]", "imu_jitter_s", 0.0,
       0.05, kRig},
      {"imu-dropout", &o.rig.imu_dropout, "X", "Fraction of the IMU samples that are missing",
       "imu_dropout", 0.0, 0.9, kRig},
      {"out", &o.out, "DIR", "Folder for the data and the report"},
      {"ablation", &o.ablation, "",
       "Run the chosen methods also with one ingredient changed at a time"},
      {"downstream", &o.downstream_s, "SECONDS",
       "Start the back end from every accepted estimate and run it for this long [s] (0: do not)",
       "downstream_s", 0.0, 600.0},
      {"report", &o.report, "MODE",
       "report.md and report.html; auto: if python3 has pandas, matplotlib and jinja2", "", 0.0,
       0.0, OptionScope::kAlways, reports},
      {"quiet", &o.quiet, "", "No progress bar and no table"},
  };
}

std::string setOption(const AbOption& option, const std::string& text) {
  return std::visit(
      [&](auto* field) -> std::string {
        using T = Pointee<decltype(field)>;
        if constexpr (std::is_same_v<T, bool>) {
          *field = true;
        } else if constexpr (std::is_same_v<T, std::string>) {
          if (!option.choices.empty() && !contains(option.choices, text)) {
            return "--" + option.name + " is '" + text +
                   "', must be one of: " + join(option.choices, ", ");
          }
          if (text.empty()) return "--" + option.name + " is empty, must be " + option.value_name;
          *field = text;
        } else if (!readNumber(text, option.min, option.max, field)) {
          return "--" + option.name + ": '" + text + "' is not " + allowedText<T>(option);
        }
        return "";
      },
      option.field);
}

std::string valueText(const AbOption& option) {
  return std::visit(
      [](auto* field) -> std::string {
        using T = Pointee<decltype(field)>;
        if constexpr (std::is_same_v<T, std::string>) return *field;
        if constexpr (kIsNumber<T>) return numberText(static_cast<double>(*field));
        return "";
      },
      option.field);
}

std::string rangeText(const AbOption& option) {
  return std::visit(
      [&](auto* field) -> std::string {
        if constexpr (!kIsNumber<Pointee<decltype(field)>>) return join(option.choices, ", ");
        return numberText(option.min) + " to " + numberText(option.max);
      },
      option.field);
}

void checkAbOptions(AbOptions* options) {
  AbOptions& o = *options;
  checkSource(o);
  mergeFile(options);
  if (o.first_keyframes > 0 && o.gates == "off") {
    check((typed(o, "gates") ? "--gates" : fileOfOptions(o) + ": slim_init.gates.mode") +
          " off: no method would wait for its window to expand (--keyframes " + o.keyframes_text +
          "); --keyframes 10 has windows of one size");
  }
  o.rig.seed = o.seed;
  checkMethods(options);
}

NamedValues describeAbOptions(const AbOptions& options) {
  AbOptions copy = options;  // the table binds to fields that can be written
  NamedValues list;
  for (const AbOption& option : abOptionTable(&copy)) {
    if (option.report_key.empty()) continue;
    if (option.name == "duration" && options.builtin.empty()) continue;
    if (option.name == "speed" && !typed(options, "speed")) continue;
    const bool of_rig = option.name == "seed" && options.rig.any();
    if (option.scope == OptionScope::kSimulatedFeatures && options.hasImages() && !of_rig) continue;
    if (option.scope == OptionScope::kRig && !typed(options, option.name.c_str())) continue;
    if (option.name == "keyframes") {
      if (options.first_keyframes > 0) {
        list.emplace_back(option.report_key, options.keyframes_text);
      } else {
        list.emplace_back(option.report_key, static_cast<std::int64_t>(options.keyframes));
      }
      continue;
    }
    if (option.name == "methods") {
      list.emplace_back(option.report_key, options.method_names);
      continue;
    }
    std::visit(
        [&](auto* field) {
          using T = Pointee<decltype(field)>;
          if constexpr (std::is_same_v<T, std::string>) {
            if (!field->empty()) list.emplace_back(option.report_key, *field);
          } else if constexpr (std::is_integral_v<T>) {
            list.emplace_back(option.report_key, static_cast<std::int64_t>(*field));
          } else {
            list.emplace_back(option.report_key, *field);
          }
        },
        option.field);
  }
  // No options of the command line.
  list.emplace_back("interval_s", options.initializer.window.min_interval_s);
  list.emplace_back("span_s", options.initializer.window.max_span_s);
  if (!options.hasImages()) list.emplace_back("line_noise", options.features.line_noise);
  list.insert(list.end(), options.file_values.begin(), options.file_values.end());
  return list;
}

}  // namespace slim_init::tools
