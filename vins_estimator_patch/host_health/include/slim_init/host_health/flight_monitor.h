// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The status of a host's states, from the findings of its frames one by one.
#pragma once

#include <string>

#include "slim_init/result.h"

namespace slim_init::host_health {

/// What was found about a host's states at one frame.
struct HostHealth {
  bool healthy = true;   ///< no failure is reported
  bool suspect = false;  ///< something speaks against the state, which may not be a failure yet
  /// Newest frame [s], camera clock, of a window that was solved without the host's states and
  /// agrees with them; NaN: none has been compared for this frame, or it contradicts them.
  double confirmed_stamp = kNotComputed;
  std::string reason;  ///< the checks that failed, with value and limit; empty: none
  /// The calibration that the window solved for this frame has found, if any.
  OptionalCalibration calibration;
  /// Of tracks triangulated between the window's older poses and seen again in the newest, median
  /// [px]; NaN: too few.
  double reprojection_px = kNotComputed;
  /// Of the newest state from an older one of the window, propagated there by the IMU; NaN: not
  /// compared.
  double velocity_mps = kNotComputed;
  double rotation_deg = kNotComputed;
};

/// The health of a host's states.
enum class FlightStatus {
  kGood,
  kSuspect,  ///< something speaks against them, or nothing has spoken for them since it did
  kWrong     ///< a failure; recoveries are tried
};

/// The lower-case name of the enumerator.
const char* toString(FlightStatus status);

/// Turns the findings of each frame into a status. After a failure, a recovery or damaged data the
/// states are good again only when a window of kEvidence more data, solved without them, agrees, or
/// after kUnopposed with nothing against them: at constant velocity no window can be solved. Not
/// thread-safe.
class FlightMonitor {
 public:
  static constexpr double kEvidence = 0.5;    ///< [s]
  static constexpr double kUnopposed = 10.0;  ///< [s]

  /// The states have restarted: nothing is known against them.
  void reset();
  /// At `stamp` [s] the data were damaged, or the states were replaced after a failure, which then
  /// has ended.
  void doubt(double stamp);
  void recovered(double stamp);
  /// The finding of the frame at `stamp` [s]; returns what a person should read, or "".
  std::string update(double stamp, const HostHealth& health);

  FlightStatus status() const;
  /// A window solved without the host's states would decide.
  bool wantsEvidence(double stamp) const;
  /// The newest frame was not to be trusted.
  bool suspectsFrame() const { return frame_suspect_; }
  double alarmStamp() const { return alarm_stamp_; }  ///< begin of the failure [s]
  /// The alarm is counted from here on again [s].
  void restartAlarm(double stamp) { alarm_stamp_ = stamp; }

 private:
  bool alarm_ = false;
  bool frame_suspect_ = false;
  bool reported_ = false;  // a failure that has not been called off
  double alarm_stamp_ = kNotComputed;
  double last_trouble_ = kNotComputed;  // NaN: no doubt
};

}  // namespace slim_init::host_health
