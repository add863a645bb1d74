// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::evaluation {

/// One sequence ready for evaluation: what the sensors said and what was true.
struct Sequence {
  std::string name;
  Calibration calibration;
  std::int64_t t0_ns = 0;                ///< stamp of t = 0 in the recording [ns]
  std::vector<ImuSample> imu;            ///< ascending in time
  std::vector<FrameObservation> frames;  ///< ascending in time
  /// Truth at the instant of frames[i] (frames[i].t + calibration.td on the IMU clock), one entry
  /// per frame; t is NaN where there is none.
  std::vector<NavState> truth;
  bool has_gyro_bias_truth = false;  ///< else truth[].gyro_bias was fitted to gyro and orientation
  std::vector<std::string> notes;    ///< what the reader of a report must know about the data
};

}  // namespace slim_init::evaluation
