// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

namespace slim_init::feature_tracker_lines {

/// Wall-clock time since construction or the last lap.
class Stopwatch {
 public:
  /// Returns the time [ms] and restarts.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - start_).count();
    start_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace slim_init::feature_tracker_lines
