// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/node_streams.h"

#include "slim_init/ros/conversions.h"

namespace slim_init::node {

NodeStreams::NodeStreams(const std::vector<Stream>& streams) {
  for (const Stream& stream : streams) {
    monitors_.emplace_back(stream.name, stream.kind, stream.required);
  }
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

}  // namespace slim_init::node
