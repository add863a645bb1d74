// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

namespace slim_init::node {

/// Stamps of messages to seconds and back. Seconds since 1970 as a double are good to 0.2 us only:
/// the first stamp becomes t = 0, and the nanoseconds are subtracted as integers.
class StampClock {
 public:
  /// [s] after the first stamp ever passed.
  double seconds(std::int64_t stamp_ns) {
    if (!started_) t0_ns_ = stamp_ns;
    started_ = true;
    return 1e-9 * static_cast<double>(stamp_ns - t0_ns_);
  }

  std::int64_t stampNs(double t) const { return t0_ns_ + std::llround(1e9 * t); }

 private:
  bool started_ = false;
  std::int64_t t0_ns_ = 0;
};

}  // namespace slim_init::node
