// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <sstream>

#include "evaluation/scratch_folder.h"

namespace slim_init {

/// A recording of a body that swings about, written with `gap_s` seconds of IMU left out at 2 s.
inline void writeRecording(const ScratchFolder& folder, double duration_s, double gap_s) {
  std::ostringstream imu;
  std::ostringstream images;
  std::ostringstream truth;
  for (std::ostringstream* file : {&imu, &images, &truth}) {
    *file << "#timestamp [ns]\n";
    file->precision(12);
  }
  const std::int64_t t0 = 1400000000000000000;
  for (int k = 0; k <= static_cast<int>(200.0 * duration_s); ++k) {
    const double t = k / 200.0;
    const std::int64_t stamp = t0 + 5000000LL * k;
    const double w = 2.0;
    // p = (1 - cos wt, 0, 0.5 (1 - cos wt)), no rotation.
    const double p = 1.0 - std::cos(w * t);
    const double a = w * w * std::cos(w * t);
    if (t < 2.0 || t >= 2.0 + gap_s) {
      imu << stamp << ",0.01,0.02,-0.03," << a << ",0," << 0.5 * a + 9.81007 << "\n";
    }
    if (k % 10 == 0) images << stamp << "\n";
    if (k % 4 == 0) truth << stamp << "," << p << ",0," << 0.5 * p << ",1,0,0,0\n";
  }
  folder.write("imu0.csv", imu.str());
  folder.write("cam0_timestamps.csv", images.str());
  folder.write("groundtruth.csv", truth.str());
}

}  // namespace slim_init
