// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What goes wrong with the streams of a rig: one table of faults, for `slim_init_bench faults` and
// `slim_init_bench soak`.
#pragma once

#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::tools {

/// A message and when it reaches the program.
template <typename Message>
struct Delivered {
  double arrival = 0.0;  ///< [s], sequence time
  double true_t = 0.0;   ///< when it was measured, IMU clock [s]
  Message message;       ///< with the stamp that it carries
};

/// Everything that a host receives, from the place on where it starts.
struct Streams {
  std::vector<Delivered<ImuSample>> imu;
  std::vector<Delivered<FrameObservation>> frames;
  Calibration calibration;  ///< as the host is told
  /// When the host is restarted [s].
  double restart = std::numeric_limits<double>::infinity();
};

/// When there is trouble: for 0.6 s, or the whole start for faults that last [s, sequence time].
struct Trouble {
  double begin = 0.0;
  double end = 0.0;
  bool holds(double t) const { return t >= begin && t < end; }
};

/// What a fault is applied to.
struct FaultInput {
  Trouble trouble;
  std::mt19937_64& random;
  Streams& streams;
};

/// One kind of fault.
struct StreamFault {
  const char* name;
  const char* what;  ///< one line for the table
  bool lasts;        ///< from the start to the end, else during Trouble alone
  std::function<void(const FaultInput& in)> apply;
};

/// All kinds; the first is none.
const std::vector<StreamFault>& streamFaults();

}  // namespace slim_init::tools
