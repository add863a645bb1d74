// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/imu_instants.h"

#include <algorithm>

namespace slim_init {

// Five samples at 200 Hz [s].
constexpr double kInstantSpan = 0.012;

std::vector<ImuInstant> imuInstants(const InitWindow& window, double td_shift,
                                    const Eigen::Vector3d& gyro_bias,
                                    const Eigen::Vector3d& accel_bias) {
  const std::vector<ImuSample>& imu = window.imu();
  std::vector<ImuInstant> instants;
  instants.reserve(window.size());
  for (const double keyframe : window.times()) {
    const double t = keyframe + td_shift;
    auto first = std::lower_bound(imu.begin(), imu.end(), t - kInstantSpan,
                                  [](const ImuSample& s, double time) { return s.t < time; });
    if (first == imu.end()) --first;
    ImuInstant sum;
    int count = 0;
    for (auto sample = first; sample != imu.end() && sample->t <= t + kInstantSpan; ++sample) {
      sum.rate += sample->gyro;
      sum.force += sample->accel;
      ++count;
    }
    if (count == 0) {
      // A slow IMU: the sample after the instant.
      sum = {first->gyro, first->accel};
      count = 1;
    }
    instants.push_back({sum.rate / count - gyro_bias, sum.force / count - accel_bias});
  }
  return instants;
}

}  // namespace slim_init
