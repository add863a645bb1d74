// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace slim_init::node {

/// Messages that were sent and never came, from the numbers that a ROS publisher writes into the
/// headers. Numbers that are no count (all zero, several publishers) are ignored.
class SequenceGaps {
 public:
  void add(std::uint32_t sequence) {
    constexpr std::uint32_t kNoCount = 10000;  // a step as large is a restarted publisher
    const std::uint32_t step = sequence - last_;
    if (started_ && step > 1 && step < kNoCount) lost_ += step - 1;
    started_ = true;
    last_ = sequence;
  }

  std::int64_t lost() const { return lost_; }

 private:
  bool started_ = false;
  std::uint32_t last_ = 0;
  std::int64_t lost_ = 0;
};

}  // namespace slim_init::node
