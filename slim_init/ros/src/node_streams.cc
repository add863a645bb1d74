// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/node_streams.h"

#include <ros/console.h>

#include "slim_init/ros/conversions.h"

namespace slim_init::node {
namespace {

std::vector<TimeGuard::Stream> guarded(const std::vector<NodeStreams::Stream>& streams) {
  std::vector<TimeGuard::Stream> result;
  for (const NodeStreams::Stream& stream : streams) result.push_back({stream.restart_on_gap});
  return result;
}

}  // namespace

NodeStreams::NodeStreams(const std::vector<Stream>& streams, const std::function<void()>& restart)
    : restart_(restart), guard_(guarded(streams)) {
  for (const Stream& stream : streams) monitors_.emplace_back(stream.name, stream.required);
}

bool NodeStreams::accept(int stream, const std_msgs::Header& header, const std::string& problem,
                         double* t) {
  monitors_[stream].received(header.seq);
  if (!problem.empty()) {
    monitors_[stream].garbage(problem);
    return false;
  }
  const StampVerdict verdict = guard_.check(stream, header.stamp.toSec());
  if (verdict == StampVerdict::kRestart) {
    ROS_WARN_STREAM("time jumped to " << header.stamp << ": all data is forgotten");
    restart_();
  } else if (verdict != StampVerdict::kUse) {
    return false;
  }
  *t = clock_.seconds(stampNs(header.stamp));
  return true;
}

diagnostic_msgs::DiagnosticStatus NodeStreams::report() {
  diagnostic_msgs::DiagnosticStatus status = makeStatus("streams", "data is coming");
  for (std::size_t i = 0; i < monitors_.size(); ++i) {
    monitors_[i].report(guard_.counts(static_cast<int>(i)), &status);
  }
  return status;
}

}  // namespace slim_init::node
