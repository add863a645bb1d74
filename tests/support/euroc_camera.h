// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slim_init/feature_tracker_lines/camera.h"

namespace slim_init {

/// A camera with size, focal lengths and centre [px]; a pinhole without distortion unless it is
/// changed.
inline feature_tracker_lines::CameraParameters cameraOf(int width, int height, double fx, double fy,
                                                        double cx, double cy) {
  feature_tracker_lines::CameraParameters camera;
  camera.width = width;
  camera.height = height;
  camera.fx = fx;
  camera.fy = fy;
  camera.cx = cx;
  camera.cy = cy;
  return camera;
}

/// EuRoC's cam0 (sensor.yaml of the dataset).
inline feature_tracker_lines::CameraParameters eurocCamera() {
  auto camera = cameraOf(752, 480, 458.654, 457.296, 367.215, 248.375);
  camera.distortion = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  return camera;
}

}  // namespace slim_init
