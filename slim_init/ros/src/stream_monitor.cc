// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/stream_monitor.h"

#include <ros/console.h>
#include <ros/this_node.h>

#include "slim_init/ros/conversions.h"
#include "slim_init/text.h"

namespace slim_init::node {

using diagnostic_msgs::DiagnosticStatus;

namespace {

constexpr double kSilence = 2.0;  // [s], wall clock
// A step in the numbers of the headers as large is a restarted publisher.
constexpr std::uint32_t kNoCount = 10000;

}  // namespace

void raise(int level, const std::string& message, DiagnosticStatus* status) {
  status->message =
      status->level == DiagnosticStatus::OK ? message : status->message + "; " + message;
  if (level > status->level) status->level = static_cast<DiagnosticStatus::_level_type>(level);
}

DiagnosticStatus makeStatus(const std::string& part, const std::string& message) {
  DiagnosticStatus status;
  status.name = ros::this_node::getName().substr(1) + ": " + part;
  status.message = message;
  status.hardware_id = "slim_init";
  return status;
}

bool NodeStreams::accept(int stream, const std_msgs::Header& header, const std::string& problem,
                         double* t) {
  InputStream& s = streams_[stream];
  const std::uint32_t step = header.seq - s.sequence;
  if (s.received++ > 0 && step > 1 && step < kNoCount) s.lost += step - 1;
  s.sequence = header.seq;
  s.newest = ros::WallTime::now();
  if (!problem.empty() || header.stamp.isZero()) {
    ++s.malformed;
    explain(stream, problem.empty() ? "the header has no stamp" : problem);
    return false;
  }
  *t = clock_.seconds(stampNs(header.stamp));
  return true;
}

void NodeStreams::explain(int stream, const std::string& reason) {
  streams_[stream].last_reason = reason;
  ROS_WARN_STREAM_THROTTLE(5.0, streams_[stream].name << " message discarded: " << reason);
}

DiagnosticStatus NodeStreams::report(const StreamCounts& counts) {
  DiagnosticStatus status = makeStatus("streams", "data is coming");
  for (InputStream& s : streams_) {
    const double silent = (ros::WallTime::now() - s.newest).toSec();
    if (s.required && silent > kSilence) {
      raise(DiagnosticStatus::ERROR,
            roundedText(3, "no ", s.name, " message for ", silent, " s (limit ", kSilence, " s)"),
            &status);
    }
    addValue(s.name + " received", s.received, &status);
    addValue(s.name + " lost", s.lost, &status);
    addValue(s.name + " discarded: malformed", s.malformed, &status);
    std::int64_t dropped = s.malformed + s.lost;
    for (int i = 0; i < MessageCounts::kStatuses; ++i) {
      const auto reason = static_cast<AddStatus>(i);
      if (!isDropped(reason)) continue;
      const std::int64_t count = (counts.*s.counts)[reason];
      addValue(s.name + " discarded: " + toString(reason), count, &status);
      dropped += count;
    }
    if (!s.last_reason.empty()) addValue(s.name + " last discarded", s.last_reason, &status);
    if (dropped > s.dropped_before) {
      raise(
          DiagnosticStatus::WARN,
          std::to_string(dropped - s.dropped_before) + " " + s.name + " messages lost or discarded",
          &status);
    }
    s.dropped_before = dropped;
  }
  return status;
}

void Diagnostics::start(const std::function<Statuses()>& collect) {
  publisher_ = handle_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
  timer_ =
      handle_.createWallTimer(ros::WallDuration(1.0), [this, collect](const ros::WallTimerEvent&) {
        diagnostic_msgs::DiagnosticArray message;
        message.header.stamp = ros::Time::now();
        message.status = collect();
        publisher_.publish(message);
      });
}

}  // namespace slim_init::node
