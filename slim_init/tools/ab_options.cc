// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "ab_options.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <type_traits>

#include "slim_init/simulation/trajectory.h"
#include "slim_init/window_solver.h"

namespace slim_init::tools {
namespace {

template <typename T>
std::string rangeText(T min, T max) {
  std::ostringstream out;
  out.precision(10);
  out << (std::is_integral<T>::value ? "a whole number" : "a number") << " in [" << min << ", "
      << max << "]";
  return out.str();
}

/// Reads all of `text` as a T in [min, max]; NaN is in no range.
template <typename T>
bool inRange(const std::string& text, T min, T max) {
  char* end = nullptr;
  errno = 0;
  if (std::is_integral<T>::value) {
    const long long value = std::strtoll(text.c_str(), &end, 10);
    return errno == 0 && !text.empty() && *end == '\0' && value >= static_cast<long long>(min) &&
           value <= static_cast<long long>(max);
  }
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && value >= static_cast<double>(min) &&
         value <= static_cast<double>(max);
}

/// An option with a bound. The check sees the text before CLI11 converts it, so that one sentence
/// covers "abc", "nan" and 99.
template <typename T>
void addNumber(CLI::App& app, const std::string& name, T& field, T min, T max,
               const std::string& help) {
  const CLI::Validator check(
      [min, max](std::string& text) -> std::string {
        if (!inRange(text, min, max)) return "'" + text + "' is not " + rangeText(min, max);
        // Some CLI11 versions take a leading zero for an octal number.
        if (std::is_integral<T>::value)
          text = std::to_string(std::strtoll(text.c_str(), nullptr, 10));
        return "";
      },
      std::string());
  app.add_option(name, field, help)->capture_default_str()->transform(check);
}

std::string join(const std::vector<std::string>& names) {
  std::string joined;
  for (const std::string& name : names) joined += (joined.empty() ? "" : ", ") + name;
  return joined;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string checkMethods(AbOptions* options) {
  if (options->methods.empty()) {
    options->method_names = solverNames();
    return "";
  }
  options->method_names.clear();
  std::istringstream list(options->methods + ",");
  for (std::string name; std::getline(list, name, ',');) {
    if (!contains(solverNames(), name)) {
      return "--methods names '" + name + "', known are: " + join(solverNames());
    }
    if (contains(options->method_names, name)) return "--methods names '" + name + "' twice";
    options->method_names.push_back(name);
  }
  return "";
}

}  // namespace

void addAbOptions(CLI::App& app, AbOptions* options) {
  AbOptions& o = *options;
  simulation::FeatureSimulationOptions& f = o.features;

  app.add_option("--recorded", o.recorded,
                 "Folder with imu0.csv, cam0_timestamps.csv, groundtruth.csv: real IMU data, "
                 "features simulated along the true path");
  app.add_option("--builtin", o.builtin,
                 "Simulated motion: " + join(simulation::builtinTrajectoryNames()));
  app.add_option("--world", o.world, "Scene: room, hall or corridor")->capture_default_str();
  app.add_option("--methods", o.methods,
                 "Methods, comma separated: " + join(solverNames()) + " (default: all)");
  app.add_option("--gates", o.gates,
                 "Whose checks decide: own (as published), on or off for every method")
      ->capture_default_str();
  app.add_option("--out", o.out, "Folder for the report")->capture_default_str();
  app.add_flag("--quiet", o.quiet, "No progress bar and no table");

  addNumber(app, "--stride", o.stride, 1, 100000, "Images between the starts of two windows");
  addNumber(app, "--keyframes", o.keyframes, 4, 15, "Keyframes of a window");
  addNumber(app, "--limit", o.limit, 0, 1000000000, "Stop after this many windows; 0: no limit");
  addNumber(app, "--seed", o.seed, 0u, std::numeric_limits<unsigned>::max(),
            "Seed of everything random; equal seeds give equal windows");
  addNumber(app, "--duration", o.duration_s, 3.0, 3600.0, "Length of a built-in motion [s]");
  addNumber(app, "--points", f.max_points, 0, 2000, "Points tracked in one image");
  addNumber(app, "--lines", f.max_lines, 0, 500, "Lines tracked in one image");
  addNumber(app, "--pixel-noise", f.pixel_noise, 0.0, 10.0, "Noise of a point, per axis [px]");
  addNumber(app, "--drift", f.drift, 0.0, 10.0,
            "Random walk of a point track, per image and axis [px]");
  addNumber(app, "--outliers", f.outlier_rate, 0.0, 1.0, "Share of point tracks that slide off");
  addNumber(app, "--track-life", f.track_life, 1.0, 1e6, "Mean life of a track [images]");
  addNumber(app, "--line-fragmentation", f.line_fragmentation, 0.0, 1.0,
            "Chance per line and image that its track breaks");
  addNumber(app, "--line-misassociation", f.line_misassociation, 0.0, 1.0,
            "Chance per line and image that it jumps to a wrong line");
}

std::string checkAbOptions(AbOptions* options) {
  AbOptions& o = *options;
  if (o.recorded.empty() == o.builtin.empty()) {
    return o.recorded.empty() ? "one of --recorded DIR and --builtin NAME is needed"
                              : "--recorded and --builtin exclude each other";
  }
  if (!o.builtin.empty() && !contains(simulation::builtinTrajectoryNames(), o.builtin)) {
    return "--builtin is '" + o.builtin +
           "', known are: " + join(simulation::builtinTrajectoryNames());
  }
  if (!simulation::parseWorldKind(o.world, &o.world_kind)) {
    return "--world is '" + o.world + "', must be room, hall or corridor";
  }
  if (o.gates == "own") {
    o.gate_mode = GateMode::kOwn;
  } else if (o.gates == "on") {
    o.gate_mode = GateMode::kOn;
  } else if (o.gates == "off") {
    o.gate_mode = GateMode::kOff;
  } else {
    return "--gates is '" + o.gates + "', must be own, on or off";
  }
  if (o.out.empty()) return "--out is empty, must name a folder";
  return checkMethods(options);
}

std::vector<std::pair<std::string, evaluation::OptionValue>> describeAbOptions(
    const AbOptions& options) {
  const auto integer = [](std::int64_t value) { return evaluation::OptionValue(value); };
  const simulation::FeatureSimulationOptions& f = options.features;
  std::vector<std::pair<std::string, evaluation::OptionValue>> list;
  if (!options.recorded.empty()) list.emplace_back("recorded", options.recorded);
  if (!options.builtin.empty()) {
    list.emplace_back("builtin", options.builtin);
    list.emplace_back("duration_s", options.duration_s);
  }
  list.emplace_back("world", options.world);
  list.emplace_back("methods", options.method_names);
  list.emplace_back("gates", options.gates);
  list.emplace_back("seed", integer(options.seed));
  list.emplace_back("stride", integer(options.stride));
  list.emplace_back("keyframes", integer(options.keyframes));
  list.emplace_back("limit", integer(options.limit));
  list.emplace_back("points", integer(f.max_points));
  list.emplace_back("lines", integer(f.max_lines));
  list.emplace_back("pixel_noise", f.pixel_noise);
  list.emplace_back("line_noise", f.line_noise);
  list.emplace_back("drift", f.drift);
  list.emplace_back("outliers", f.outlier_rate);
  list.emplace_back("track_life", f.track_life);
  list.emplace_back("line_fragmentation", f.line_fragmentation);
  list.emplace_back("line_misassociation", f.line_misassociation);
  return list;
}

}  // namespace slim_init::tools
