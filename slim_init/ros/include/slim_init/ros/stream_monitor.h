// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The standard diagnostics of the nodes: is data coming, and what became of it.
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/node_handle.h>

#include <cstdint>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "slim_init/ros/sequence_gaps.h"
#include "slim_init/ros/time_guard.h"

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

/// A status named "<node>: <part>" at level OK, with what to say while it stays there.
diagnostic_msgs::DiagnosticStatus makeStatus(const std::string& part, const std::string& message);

/// Raises the level of a status, never lowers it, and adds a sentence; it takes the place of what
/// is said at level OK.
void raise(int level, const std::string& sentence, diagnostic_msgs::DiagnosticStatus* status);

/// One subscribed stream as the diagnostics see it.
class StreamMonitor {
 public:
  /// `name` as in "imu"; a stream that is not `required` may stay silent.
  StreamMonitor(const std::string& name, bool required) : name_(name), required_(required) {}

  /// Every message, before anything else.
  void received(std::uint32_t sequence);
  /// A message that cannot be used; `sentence` says why.
  void garbage(const std::string& sentence);

  /// Values and verdict since the last call: silence of a required stream is an error, messages
  /// lost or dropped are a warning.
  void report(const StampCounts& stamps, diagnostic_msgs::DiagnosticStatus* status);

  std::int64_t receivedCount() const { return received_; }

 private:
  static constexpr double kSilence = 2.0;  // [s], wall clock

  std::string name_;
  bool required_;
  std::int64_t received_ = 0;
  std::int64_t garbage_ = 0;
  std::string last_garbage_;
  SequenceGaps gaps_;
  // At the last report.
  std::int64_t received_before_ = 0;
  std::int64_t dropped_before_ = 0;
  ros::WallTime reported_ = ros::WallTime::now();
  ros::WallTime last_ = ros::WallTime::now();
};

/// Publishes what a node has to say about itself on /diagnostics, once a second of wall clock:
/// simulated time stands still with the bag, and then most of all one wants to know.
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
