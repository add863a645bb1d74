// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>

#include "evaluation/scratch_folder.h"

namespace slim_init {

/// A recording of a body that swings about after `rest_s` seconds at rest, written with `gap_s`
/// seconds of IMU left out at 2 s, as files that begin with `name`.
inline void writeRecording(const ScratchFolder& folder, double duration_s, double gap_s,
                           const std::string& name = "", double rest_s = 0.0) {
  std::ostringstream imu;
  std::ostringstream images;
  std::ostringstream truth;
  for (std::ostringstream* file : {&imu, &images, &truth}) {
    *file << "#timestamp [ns]\n";
    file->precision(12);
  }
  const std::int64_t t0 = 1400000000000000000;
  for (int k = 0; k <= static_cast<int>(200.0 * duration_s); ++k) {
    const double t = k / 200.0, moving = std::max(0.0, t - rest_s);
    const std::int64_t stamp = t0 + 5000000LL * k;
    const double w = 2.0;
    // p = (1 - cos wt, 0, 0.5 (1 - cos wt)) from the end of the rest on, no rotation.
    const double p = 1.0 - std::cos(w * moving);
    const double a = moving > 0.0 ? w * w * std::cos(w * moving) : 0.0;
    if (t < 2.0 || t >= 2.0 + gap_s) {
      imu << stamp << ",0.01,0.02,-0.03," << a << ",0," << 0.5 * a + 9.81007 << "\n";
    }
    if (k % 10 == 0) images << stamp << "\n";
    if (k % 4 == 0) {
      truth << stamp << "," << p << ",0," << 0.5 * p << ",1,0,0,0\n";
    }
  }
  folder.write(name + "imu0.csv", imu.str());
  folder.write(name + "cam0_timestamps.csv", images.str());
  folder.write(name + "groundtruth.csv", truth.str());
}

}  // namespace slim_init
