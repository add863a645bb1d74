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
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "slim_init/ros/sequence_gaps.h"
#include "slim_init/ros/stamp_clock.h"
#include "slim_init/stream_check.h"

namespace slim_init::node {

/// Adds one value to a diagnostic status.
template <typename T>
void addValue(const std::string& key, const T& value, diagnostic_msgs::DiagnosticStatus* status) {
  std::ostringstream out;
  out << value;
  diagnostic_msgs::KeyValue pair;
  pair.key = key;
  pair.value = out.str();
  status->values.push_back(pair);
}

/// A status named "<node>: <part>" at level OK, with the message of that level.
diagnostic_msgs::DiagnosticStatus makeStatus(const std::string& part, const std::string& message);

/// Raises the level of a status, never lowers it, and appends `message`; it replaces the message of
/// level OK.
void raise(int level, const std::string& message, diagnostic_msgs::DiagnosticStatus* status);

/// Which part of StreamCounts is about a stream.
enum class StreamKind { kImu, kFrames, kLines, kSpeeds };

/// One subscribed stream as the diagnostics see it.
class StreamMonitor {
 public:
  /// `name` as in "imu"; a stream that is not `required` may stay silent.
  StreamMonitor(const std::string& name, StreamKind kind, bool required)
      : name_(name), kind_(kind), required_(required) {}

  /// Every message, before anything else.
  void received(std::uint32_t sequence);
  /// A message that cannot be read, and why: counted here.
  void garbage(const std::string& reason);
  /// Why a message was dropped that is counted elsewhere.
  void explain(const std::string& reason);

  /// Values and status since the last call: silence of a required stream is an error, messages
  /// lost or dropped are a warning. `counts`: of what was not garbage.
  void report(const StreamCounts& counts, diagnostic_msgs::DiagnosticStatus* status);

  std::int64_t receivedCount() const { return received_; }

 private:
  static constexpr double kSilence = 2.0;  // [s], wall clock

  std::string name_;
  StreamKind kind_;
  bool required_;
  std::int64_t received_ = 0;
  std::int64_t garbage_ = 0;
  std::string last_reason_;
  SequenceGaps gaps_;
  // At the last report.
  std::int64_t received_before_ = 0;
  std::int64_t dropped_before_ = 0;
  ros::WallTime reported_ = ros::WallTime::now();
  ros::WallTime last_ = ros::WallTime::now();
};

/// The input streams of a node, in the order of their time stamps.
class NodeStreams {
 public:
  explicit NodeStreams(std::vector<StreamMonitor> monitors) : monitors_(std::move(monitors)) {}

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
