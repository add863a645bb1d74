// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slim_init/feature_tracker_lines/camera.h"

namespace slim_init::testing_support {

/// EuRoC's cam0 (sensor.yaml of the dataset).
inline feature_tracker_lines::CameraParameters eurocCamera() {
  feature_tracker_lines::CameraParameters camera;
  camera.fx = 458.654;
  camera.fy = 457.296;
  camera.cx = 367.215;
  camera.cy = 248.375;
  camera.distortion = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  return camera;
}

}  // namespace slim_init::testing_support
