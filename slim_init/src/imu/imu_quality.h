// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the samples of an IMU say about its noise, and the noise that `slim` assumes of it
// (docs/derivation.md, 4.2).
#pragma once

#include <vector>

#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/types.h"

namespace slim_init {

/// Noise and motion of a stretch of samples, measured without any other sensor.
struct ImuQuality {
  /// White noise with which samples on a smooth motion would scatter as much as these do: the noise
  /// of the sensor and what vibration leaves of itself after averaging over up to 0.04 s. Of one
  /// axis, rms of the three. NaN where there are too few samples.
  ImuNoise noise = {kNotComputed, kNotComputed};
  int differences = 0;          ///< third differences of single samples, on each axis
  double force_spread = 0.0;    ///< rms of |f - mean f| [m/s^2]
  double angular_spread = 0.0;  ///< rms of |w - mean w| [rad/s]

  /// False: too few samples; nothing is known about the noise.
  bool measured() const;
};

/// Measures `samples`, ascending in time, of any rate. Third divided differences at the samples'
/// own stamps vanish on any quadratic motion, whatever the jitter of the stamps; those that reach
/// across a gap are left out. Of averages over 1 to 8 samples the one with the least density
/// counts: on long averages motion remains, on short ones vibration. A third of the samples may be
/// outliers. Not measured with fewer than 20 differences.
ImuQuality measureImuQuality(const std::vector<ImuSample>& samples);

/// The noise to assume of an IMU with the data sheet `data_sheet` whose samples have `quality`:
/// root of the sum of squares of the data sheet (the floor), of the measured noise, and of a term
/// proportional to the motion. Without a measurement the second is left out. A noise factor of
/// `options` that is not zero is used instead, times the data sheet.
ImuNoise assumedImuNoise(const ImuNoise& data_sheet, const ImuQuality& quality,
                         const InertialOptions& options);

/// The same of a window, from all its samples and its calibration.
ImuNoise assumedImuNoise(const InitWindow& window, const InertialOptions& options);

}  // namespace slim_init
