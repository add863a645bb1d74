// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "slim_init/evaluation/image_sequence.h"

namespace slim_init::evaluation {

/// What a ground truth file gave.
struct TruthFile {
  std::vector<NavState> states;
  bool has_velocity_and_bias = false;
  int out_of_order = 0;  ///< sorted in
  int repeated = 0;      ///< dropped
  std::vector<std::string> notes;
};

/// Reads a ground truth table (8 or 17 columns).
ReadStatus readTruthFile(const std::string& path, std::int64_t t0_ns, int min_rows,
                         TruthFile* truth);

/// "FILE: 2 IMU samples repeat a stamp and were dropped, ..." or an empty string.
std::string disorderNote(const std::string& source, const std::string& things, int repeated,
                         int out_of_order);

}  // namespace slim_init::evaluation
