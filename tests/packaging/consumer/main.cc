// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The smallest use of the library: feed an initializer, ask it, act on the verdict.
#include <cstdio>
#include <memory>
#include <string>

#include "slim_init/initializer.h"

int main() {
  slim_init::Calibration calibration;  // R_b_c, t_b_c, noise, ...: EuRoC-like defaults
  slim_init::InitializerOptions options;
  std::string error;
  const std::unique_ptr<slim_init::IInitializer> initializer =
      slim_init::makeInitializer(calibration, options, &error);
  if (!initializer) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }

  // One second of a resting IMU at 200 Hz and images at 20 Hz: nothing moves yet.
  for (int i = 0; i <= 200; ++i) {
    slim_init::ImuSample sample;
    sample.t = 0.005 * i;
    sample.accel.z() = calibration.gravity_magnitude;
    initializer->addImu(sample);
    if (i % 10 != 0) continue;
    slim_init::FrameObservation frame;
    frame.t = sample.t;
    for (int id = 0; id < 20; ++id) {
      slim_init::PointObservation point;
      point.id = id;
      point.bearing = Eigen::Vector3d(0.1 * (id % 5 - 2), 0.1 * (id / 5 - 2), 1.0).normalized();
      frame.points.push_back(point);
    }
    initializer->addFrame(frame);
  }

  const slim_init::InitResult result = initializer->initialize();
  std::printf("%s: %s\n", slim_init::toString(result.status), result.message.c_str());
  if (result.success()) {
    std::printf("the newest keyframe is at %.3f m\n", result.states.back().p_w_b.norm());
  }
  return result.status == slim_init::InitStatus::kStationary ? 0 : 1;
}
