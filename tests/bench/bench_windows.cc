// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "bench_windows.h"

#include <cstdlib>
#include <iostream>

#include "ab_options.h"
#include "exit_code.h"
#include "load_sequence.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/protocol.h"
#include "slim_init/keyframe_window.h"

namespace slim_init::tools {

namespace po = boost::program_options;

namespace {

constexpr std::size_t kFramesBetweenWindows = 10;

[[noreturn]] void giveUp(const std::string& sentence) {
  std::cerr << "slim_init_bench: " << sentence << "\n";
  std::exit(1);
}

}  // namespace

evaluation::Sequence benchSequence(const BenchWindows& what) {
  AbOptions options;
  options.config = std::make_shared<const Config>();
  options.recorded = what.recorded;
  if (what.recorded.empty()) options.builtin = what.builtin;
  options.duration_s = what.duration_s;
  options.features.outlier_rate = 0.03;
  options.features.drift = what.drift;
  options.seed = what.seed;
  try {
    checkAbOptions(&options);
    return loadSequence(options).sequence;
  } catch (const Failure& failure) {
    giveUp(failure.what());
  }
}

std::vector<std::shared_ptr<const InitWindow>> cutWindows(const evaluation::Sequence& data,
                                                          const BenchWindows& what) {
  const WindowOptions window = evaluation::paperWindow();
  KeyframeWindow stream(data.calibration, window);
  std::vector<std::shared_ptr<const InitWindow>> all;
  std::size_t next_imu = 0;
  for (std::size_t k = 0; k < data.frames.size(); ++k) {
    while (next_imu < data.imu.size() && data.imu[next_imu].t <= data.frames[k].t + 0.01) {
      stream.addImu(data.imu[next_imu++]);
    }
    stream.addFrame(data.frames[k]);
    if (k % kFramesBetweenWindows != kFramesBetweenWindows - 1) continue;
    const WindowCut cut = stream.cut();
    if (cut.window != nullptr && cut.window->size() == window.keyframes) all.push_back(cut.window);
  }
  if (all.empty()) {
    giveUp(data.name + " holds no window of " + std::to_string(window.keyframes) + " keyframes");
  }
  if (all.size() <= what.limit) return all;
  std::vector<std::shared_ptr<const InitWindow>> spread;
  for (std::size_t k = 0; k < what.limit; ++k) spread.push_back(all[k * all.size() / what.limit]);
  return spread;
}

void addSequenceOptions(std::vector<std::string>* folders, BenchWindows* what,
                        po::options_description* table) {
  auto add = table->add_options();
  add("help", "this text");
  add("recorded", po::value(folders)->composing(),
      "folder of a recording without pixels; may be repeated");
  add("builtin", po::value(&what->builtin)->default_value(what->builtin), "built-in motion");
  add("duration", po::value(&what->duration_s)->default_value(what->duration_s),
      "of a built-in motion [s]");
  add("seed", po::value(&what->seed)->default_value(what->seed), "of the simulation");
}

std::optional<int> readOptions(const po::options_description& table,
                               const std::vector<std::string>& arguments) {
  try {
    po::variables_map given;
    po::store(po::command_line_parser(arguments).options(table).run(), given);
    if (given.count("help") > 0) {
      std::cout << table;
      return kExitOk;
    }
    po::notify(given);
  } catch (const po::error& error) {
    std::cerr << "slim_init_bench: " << error.what() << "\n";
    return kExitBadInput;
  }
  return std::nullopt;
}

}  // namespace slim_init::tools
