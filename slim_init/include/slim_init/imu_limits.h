// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Glitches of an IMU in a live stream.
#pragma once

#include <string>

#include "slim_init/types.h"

namespace slim_init {

/// A sample with an axis beyond these is a glitch of the driver or the bus and not motion: MEMS
/// IMUs of such rigs measure up to 16 g and 2000 deg/s. One such sample makes every attempt fail
/// (inertial chi-square) for as long as it is in the window; StreamCheck drops and counts it.
/// Infinity: no limit.
struct ImuLimits {
  double max_accel = 160.0;  ///< [m/s^2]
  double max_gyro = 35.0;    ///< [rad/s]

  /// False for a sample with a value that is not finite: that is another defect.
  bool exceededBy(const ImuSample& sample) const;

  /// The largest values of a sample and the limits, for a message.
  std::string describe(const ImuSample& sample) const;

  /// Returns an empty string, or a message naming the field, its value and the violated bound: no
  /// range of a MEMS sensor ends below 2 g or 125 deg/s, so that a limit given in g is refused.
  std::string validate() const;
};

}  // namespace slim_init
