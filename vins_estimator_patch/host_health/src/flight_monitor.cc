// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/host_health/flight_monitor.h"

#include <cmath>
#include <utility>

namespace slim_init::host_health {

const char* toString(FlightStatus status) {
  switch (status) {
    case FlightStatus::kGood: return "good";
    case FlightStatus::kSuspect: return "suspect";
    case FlightStatus::kWrong: return "wrong";
  }
  return "unknown";
}

void FlightMonitor::reset() { *this = FlightMonitor(); }

// fmax(): the first trouble is compared to NaN.
void FlightMonitor::doubt(double stamp) { last_trouble_ = std::fmax(last_trouble_, stamp); }

void FlightMonitor::recovered(double stamp) {
  alarm_ = frame_suspect_ = false;
  doubt(stamp);
}

std::string FlightMonitor::update(double stamp, const HostHealth& health) {
  frame_suspect_ = health.suspect || !health.healthy;
  if (frame_suspect_) doubt(stamp);
  if (!health.healthy && !alarm_) {
    alarm_ = reported_ = true;
    alarm_stamp_ = stamp;
    return "the host's states are inconsistent: " + health.reason;
  }
  if (std::isnan(last_trouble_) || frame_suspect_) return "";
  const bool confirmed = health.confirmed_stamp - last_trouble_ >= kEvidence;
  if (!confirmed && stamp - last_trouble_ < kUnopposed) return "";
  last_trouble_ = kNotComputed;
  alarm_ = false;
  if (!std::exchange(reported_, false)) return "";
  return confirmed ? "the host's states are healthy again: an independent solve agrees"
                   : "no check has failed for 10 s; the motion does not "
                     "show whether their scale is correct";
}

FlightStatus FlightMonitor::status() const {
  if (alarm_) return FlightStatus::kWrong;
  return std::isnan(last_trouble_) && !frame_suspect_ ? FlightStatus::kGood
                                                      : FlightStatus::kSuspect;
}

bool FlightMonitor::wantsEvidence(double stamp) const { return stamp - last_trouble_ >= kEvidence; }

}  // namespace slim_init::host_health
