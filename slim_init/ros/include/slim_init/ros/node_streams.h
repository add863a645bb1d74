// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The subscribed streams of a node: from message headers to the node's clock, and diagnostics.
#pragma once

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <string>
#include <vector>

#include "slim_init/ros/stamp_clock.h"
#include "slim_init/ros/stream_monitor.h"
#include "slim_init/stream_check.h"

namespace slim_init::node {

/// The input streams of a node, in the order of their time stamps.
class NodeStreams {
 public:
  /// One of the input streams.
  struct Stream {
    std::string name;                      ///< as in "imu"
    StreamKind kind = StreamKind::kOther;  ///< which part of StreamCounts is about it
    bool required = true;                  ///< its silence is an error
  };

  explicit NodeStreams(const std::vector<Stream>& streams);

  /// Takes in a message; `problem` is why it cannot be used, or "". True: `t` is its
  /// time [s] on clock(), and the rest of the checks is StreamCheck's. False: it has a problem or
  /// no stamp, and was dropped and counted. `stream`: index into the constructor's list.
  bool accept(int stream, const std_msgs::Header& header, const std::string& problem, double* t);

  /// Logs why a message was dropped after it was accepted; diagnostics show the last reason.
  void explain(int stream, const std::string& reason) { monitors_[stream].explain(reason); }

  const StampClock& clock() const { return clock_; }
  std::int64_t received(int stream) const { return monitors_[stream].receivedCount(); }

  /// The part "streams" of the diagnostics, since the last call.
  diagnostic_msgs::DiagnosticStatus report(const StreamCounts& counts);

 private:
  std::vector<StreamMonitor> monitors_;
  StampClock clock_;
};

}  // namespace slim_init::node
