// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Glitches of an IMU in a live stream.
#pragma once

#include <string>

#include "slim_init/types.h"

namespace slim_init {

/// A sample with an axis beyond these is a glitch of the driver or the bus and not motion: the IMUs
/// of such rigs measure to 16 g and 2000 deg/s at the most. One in the window has every start
/// refused (chi-square) for as long as it is in it. The window itself takes every finite sample;
/// who feeds it from a live stream asks here first and counts. Infinity: no limit.
struct ImuLimits {
  double max_accel = 160.0;  ///< [m/s^2]
  double max_gyro = 35.0;    ///< [rad/s]

  /// False for a sample with a value that is not finite: that is another defect.
  bool exceededBy(const ImuSample& sample) const;

  /// The largest values of a sample and the limits, for a person.
  std::string describe(const ImuSample& sample) const;

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound: no
  /// range of a MEMS sensor ends below 2 g or 125 deg/s. A limit given in g is met here.
  std::string validate() const;
};

}  // namespace slim_init
