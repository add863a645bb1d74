// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Windows for the benchmark program.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "slim_init/evaluation/sequence.h"
#include "slim_init/init_window.h"

namespace slim_init::tools {

/// Where windows come from and what is in them.
struct BenchWindows {
  std::string recorded;  ///< folder of a recording without pixels; empty: a built-in motion
  std::string builtin = "circle";
  double duration_s = 30.0;  ///< of a built-in motion
  int points = 100;          ///< tracked in one frame
  int lines = 25;
  double outliers = 0.03;  ///< share of the point tracks
  double drift = 0.0;      ///< random walk of a point track, per image and axis [px]
  int keyframes = 10;
  unsigned seed = 1;
  std::size_t limit = 40;  ///< windows at the most, spread over the whole sequence
};

/// Simulates or reads the sequence. Prints a sentence and ends the program where that fails.
evaluation::Sequence benchSequence(const BenchWindows& what);

/// Windows cut from the sequence, ten frames after one another; where there are more than
/// `what.limit`, every n-th of them. Ends the program where there are none.
std::vector<std::shared_ptr<const InitWindow>> cutWindows(const evaluation::Sequence& data,
                                                          const BenchWindows& what);

}  // namespace slim_init::tools
