// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Windows for the benchmark program, and the options of its commands that say which.
#pragma once

#include <boost/program_options.hpp>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slim_init/evaluation/sequence.h"
#include "slim_init/init_window.h"

namespace slim_init::tools {

/// Where windows come from and what is in them: 100 points and 25 lines in a frame, 3 % outliers.
struct BenchWindows {
  std::string recorded;  ///< folder of a recording without pixels; empty: a built-in motion
  std::string builtin = "circle";
  double duration_s = 30.0;  ///< of a built-in motion
  double drift = 0.0;        ///< random walk of a point track, per image and axis [px]
  unsigned seed = 1;
  std::size_t limit = 40;  ///< windows at the most, spread over the whole sequence
};

/// Simulates or reads the sequence. Prints a sentence and ends the program where that fails.
evaluation::Sequence benchSequence(const BenchWindows& what);

/// Windows cut from the sequence, ten frames after one another; where there are more than
/// `what.limit`, every n-th of them. Ends the program where there are none.
std::vector<std::shared_ptr<const InitWindow>> cutWindows(const evaluation::Sequence& data,
                                                          const BenchWindows& what);

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
