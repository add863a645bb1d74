// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The subscribed streams of a node: every message is counted, judged and put on the node's clock.
#pragma once

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "slim_init/ros/stamp_clock.h"
#include "slim_init/ros/stream_monitor.h"
#include "slim_init/ros/time_guard.h"

namespace slim_init::node {

class NodeStreams {
 public:
  struct Stream {
    std::string name;             ///< as in "imu"
    bool required = true;         ///< its silence is an error
    bool restart_on_gap = false;  ///< TimeGuard::Stream
  };

  /// `restart` is called when time has jumped, before the first message of the new time is used.
  NodeStreams(const std::vector<Stream>& streams, const std::function<void()>& restart);

  /// Takes in a message; `problem` says why it cannot be used, "" where it can. True: use it, `t`
  /// is its time [s] on clock(). False: it was dropped and counted. `stream`: index into the
  /// constructor's list.
  bool accept(int stream, const std_msgs::Header& header, const std::string& problem, double* t);

  const StampClock& clock() const { return clock_; }
  std::int64_t jumps() const { return guard_.restarts(); }
  std::int64_t received(int stream) const { return monitors_[stream].receivedCount(); }

  /// The part "streams" of the diagnostics, since the last call.
  diagnostic_msgs::DiagnosticStatus report();

 private:
  std::function<void()> restart_;
  TimeGuard guard_;
  std::vector<StreamMonitor> monitors_;
  StampClock clock_;
};

}  // namespace slim_init::node
