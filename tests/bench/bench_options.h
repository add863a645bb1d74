// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the commands of the benchmark program have in common on the command line.
#pragma once

#include <boost/program_options.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench_windows.h"

namespace slim_init::tools {

/// Adds `--help` and the options that say where sequences come from. `folders` and `what` live
/// longer than `table`; what they hold are the defaults.
void addSequenceOptions(std::vector<std::string>* folders, BenchWindows* what,
                        boost::program_options::options_description* table);

/// Reads the arguments after the command's name into what `table` refers to. Returns nothing where
/// the command goes on, or what the program returns: after `--help`, or after a sentence on stderr
/// about the argument at fault.
std::optional<int> readOptions(const boost::program_options::options_description& table,
                               const std::vector<std::string>& arguments);

}  // namespace slim_init::tools
