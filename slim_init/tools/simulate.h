// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ab_options.h"

namespace slim_init::tools {

/// The command line of `slim_init simulate`.
struct SimulateOptions {
  std::string csv;       ///< file of poses; one of these three
  std::string builtin;   ///< name of a motion
  std::string recorded;  ///< folder with real IMU data and image times
  std::string scene = "room";
  double start_s = 0.0;     ///< from the first image that could be rendered
  double duration_s = 0.0;  ///< of the images; 0: to the end of the motion, 20 s of a built-in one
  std::string config;       ///< YAML with camera and extrinsic; empty: EuRoC's cam0
  double image_scale = 1.0;
  double rate_hz = 20.0;  ///< of images where the motion has no image times of its own
  double speed = -1.0;    ///< noise of written speeds, as a fraction; below zero: none are written
  double imu_rate_hz = 200.0;  ///< where the IMU is simulated
  double read_noise = 1.5;
  double shot_noise = 0.04;
  double motion_blur_ms = 0.0;
  double readout_s = 0.0;  ///< rolling shutter; 0: that of `config`
  int threads = 1;
  unsigned seed = 1;
  std::string povray = "povray";
  std::string out = "out/simulate";
  std::string bag;  ///< file; empty: none
  bool quiet = false;
};

/// All options, bound to the fields of `options`; see abOptionTable().
std::vector<AbOption> simulateOptionTable(SimulateOptions* options);

/// `slim_init simulate`: renders a motion through a scene and writes images, IMU data, truth and
/// the scene itself. Returns the exit code.
int runSimulate(const SimulateOptions& options);

}  // namespace slim_init::tools
