// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The subscribed streams of a node, from message headers to its clock, and the standard
// diagnostics: is data coming, and what became of it.
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/node_handle.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "slim_init/ros/stamp_clock.h"
#include "slim_init/stream_check.h"
#include "slim_init/text.h"

namespace slim_init::node {

/// Adds one value to a diagnostic status.
template <typename T>
void addValue(const std::string& key, const T& value, diagnostic_msgs::DiagnosticStatus* status) {
  status->values.emplace_back();
  status->values.back().key = key;
  status->values.back().value = text(value);
}

/// A status named "<node>: <part>" at level OK, with the message of that level.
diagnostic_msgs::DiagnosticStatus makeStatus(const std::string& part, const std::string& message);

/// Raises the level of a status, never lowers it, and appends `message`; it replaces the message of
/// level OK.
void raise(int level, const std::string& message, diagnostic_msgs::DiagnosticStatus* status);

/// One subscribed stream.
struct InputStream {
  std::string name;                     ///< as in "imu"
  MessageCounts StreamCounts::*counts;  ///< the part that is about it
  bool required;                        ///< may not stay silent
  std::int64_t received = 0;
  std::int64_t malformed = 0;
  std::int64_t lost = 0;         ///< sent and never received, by the numbers in the headers
  std::uint32_t sequence = 0;    ///< of the newest
  std::string last_reason = {};  ///< why a message was dropped
  ros::WallTime newest = ros::WallTime::now();
  std::int64_t dropped_before = 0;  ///< at the last report
};

/// The input streams of a node, in the order of their time stamps.
class NodeStreams {
 public:
  explicit NodeStreams(std::vector<InputStream> streams) : streams_(std::move(streams)) {}

  /// Takes in a message; `problem` is why it cannot be used, or "". True: `t` is its
  /// time [s] on clock(), and the rest of the checks is StreamCheck's. False: it has a problem or
  /// no stamp, and was dropped and counted. `stream`: index into the constructor's list.
  bool accept(int stream, const std_msgs::Header& header, const std::string& problem, double* t);

  /// Logs why a message was dropped after it was accepted; diagnostics show the last reason.
  void explain(int stream, const std::string& reason);

  const StampClock& clock() const { return clock_; }
  std::int64_t received(int stream) const { return streams_[stream].received; }

  /// The part "streams" of the diagnostics: silence of a required stream is an error, messages lost
  /// or dropped since the last call are a warning. `counts`: of what accept() has let through.
  diagnostic_msgs::DiagnosticStatus report(const StreamCounts& counts);

 private:
  std::vector<InputStream> streams_;
  StampClock clock_;
};

/// Publishes the state of a node on /diagnostics, once a second of wall clock: simulated time stops
/// with the bag, and then the diagnostics matter most.
class Diagnostics {
 public:
  using Statuses = std::vector<diagnostic_msgs::DiagnosticStatus>;

  void start(const std::function<Statuses()>& collect);

 private:
  ros::NodeHandle handle_;
  ros::Publisher publisher_;
  ros::WallTimer timer_;
};

}  // namespace slim_init::node
