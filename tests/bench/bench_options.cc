// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "bench_options.h"

#include <iostream>

#include "exit_code.h"

namespace slim_init::tools {

namespace po = boost::program_options;

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
