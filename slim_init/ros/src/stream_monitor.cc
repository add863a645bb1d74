// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/stream_monitor.h"

#include <ros/console.h>
#include <ros/this_node.h>

#include <cmath>
#include <utility>

#include "slim_init/ros/conversions.h"

namespace slim_init::node {

using diagnostic_msgs::DiagnosticStatus;

namespace {

// The drops of one stream in StreamCounts, with their names in the diagnostics.
std::vector<std::pair<const char*, std::int64_t>> dropsOf(StreamKind kind,
                                                          const StreamCounts& counts) {
  switch (kind) {
    case StreamKind::kImu:
      return {{"glitch", counts.imu_glitches},
              {"late", counts.imu_out_of_order},
              {"stray stamp", counts.imu_stray},
              {"before a time jump", counts.imu_before_jump}};
    case StreamKind::kFrames:
      return {{"late", counts.frames_out_of_order},
              {"stray stamp", counts.frames_stray},
              {"before a time jump", counts.frames_before_jump}};
    case StreamKind::kLines: return {{"without frame", counts.lines_unmatched}};
    case StreamKind::kSpeeds:
      return {{"not finite", counts.speeds_not_finite},
              {"absurd speed", counts.speeds_glitches},
              {"covariance not positive definite", counts.speeds_no_covariance},
              {"sensor not calibrated", counts.speeds_not_calibrated},
              {"late", counts.speeds_out_of_order},
              {"stray stamp", counts.speeds_stray}};
  }
  return {};
}

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

void StreamMonitor::received(std::uint32_t sequence) {
  ++received_;
  gaps_.add(sequence);
  last_ = ros::WallTime::now();
}

void StreamMonitor::garbage(const std::string& reason) {
  ++garbage_;
  explain(reason);
}

void StreamMonitor::explain(const std::string& reason) {
  last_reason_ = reason;
  ROS_WARN_STREAM_THROTTLE(5.0, name_ << " message discarded: " << reason);
}

void StreamMonitor::report(const StreamCounts& counts, DiagnosticStatus* status) {
  const ros::WallTime now = ros::WallTime::now();
  const double elapsed = (now - reported_).toSec();
  const double silent = (now - last_).toSec();
  const auto drops = dropsOf(kind_, counts);
  std::int64_t dropped = garbage_ + gaps_.lost();
  for (const auto& [reason, count] : drops) dropped += count;
  const double rate =
      elapsed > 0.0 ? static_cast<double>(received_ - received_before_) / elapsed : 0.0;
  if (required_ && silent > kSilence) {
    std::ostringstream out;
    out.precision(3);
    out << "no " << name_ << " message for " << silent << " s (limit " << kSilence << " s)";
    raise(DiagnosticStatus::ERROR, out.str(), status);
  }
  if (dropped > dropped_before_) {
    raise(DiagnosticStatus::WARN,
          std::to_string(dropped - dropped_before_) + " " + name_ + " messages lost or discarded",
          status);
  }
  addValue(name_ + " received", received_, status);
  addValue(name_ + " rate [Hz]", std::round(10.0 * rate) / 10.0, status);
  addValue(name_ + " lost", gaps_.lost(), status);
  addValue(name_ + " discarded: malformed", garbage_, status);
  for (const auto& [reason, count] : drops)
    addValue(name_ + " discarded: " + reason, count, status);
  if (!last_reason_.empty()) addValue(name_ + " last discarded", last_reason_, status);
  received_before_ = received_;
  dropped_before_ = dropped;
  reported_ = now;
}

bool NodeStreams::accept(int stream, const std_msgs::Header& header, const std::string& problem,
                         double* t) {
  monitors_[stream].received(header.seq);
  const std::string reason =
      problem.empty() && header.stamp.isZero() ? "the header has no stamp" : problem;
  if (!reason.empty()) {
    monitors_[stream].garbage(reason);
    return false;
  }
  *t = clock_.seconds(stampNs(header.stamp));
  return true;
}

diagnostic_msgs::DiagnosticStatus NodeStreams::report(const StreamCounts& counts) {
  diagnostic_msgs::DiagnosticStatus status = makeStatus("streams", "data is coming");
  for (StreamMonitor& monitor : monitors_) monitor.report(counts, &status);
  return status;
}

void Diagnostics::start(const std::function<Statuses()>& collect) {
  publisher_ = handle_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
  timer_ = handle_.createWallTimer(ros::WallDuration(1.0),
                                   [this, collect](const ros::WallTimerEvent& /*event*/) {
                                     diagnostic_msgs::DiagnosticArray message;
                                     message.header.stamp = ros::Time::now();
                                     message.status = collect();
                                     publisher_.publish(message);
                                   });
}

}  // namespace slim_init::node
