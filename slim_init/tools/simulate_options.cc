// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulate_options.h"

#include <limits>

#include "slim_init/simulation/scene.h"
#include "slim_init/simulation/trajectory.h"

namespace slim_init::tools {

std::vector<AbOption> simulateOptionTable(SimulateOptions* options) {
  SimulateOptions& o = *options;
  constexpr double kMaxSeed = std::numeric_limits<unsigned>::max();
  return {
      {"csv", &o.csv, "FILE",
       "Motion from poses: stamp [ns], position [m], quaternion w x y z of the body, as in EuRoC's "
       "ground truth; the IMU is simulated",
       ""},
      {"builtin", &o.builtin, "NAME", "Built-in motion; the IMU is simulated", "", 0.0, 0.0,
       OptionScope::kAlways, simulation::builtinTrajectoryNames()},
      {"recorded", &o.recorded, "DIR",
       "Folder with imu0.csv, cam0_timestamps.csv, groundtruth.csv: the real IMU and the real "
       "image times are kept",
       ""},
      {"scene", &o.scene, "NAME", "Scene", "", 0.0, 0.0, OptionScope::kAlways,
       simulation::sceneNames()},
      {"start", &o.start_s, "X", "Skip this much of the motion [s]", "", 0.0, 1e6},
      {"duration", &o.duration_s, "X",
       "Length of the images [s]; 0: to the end of the motion, 20 s of a built-in one", "", 0.0,
       1e6},
      {"config", &o.config, "FILE",
       "YAML file with camera, extrinsic and td (default: EuRoC's cam0 and IMU)", ""},
      {"image-scale", &o.image_scale, "X", "Size of the images as a multiple of the camera's", "",
       0.05, 4.0},
      {"rate", &o.rate_hz, "X", "Images per second, not with --recorded", "", 0.1, 1000.0},
      {"imu-rate", &o.imu_rate_hz, "X", "IMU samples per second, not with --recorded", "", 20.0,
       4000.0},
      {"speed", &o.speed, "X",
       "Write the forward speeds of `ab --speed X` into DIR/mav0/speed0/data.csv and the bag's "
       "/speed0",
       "", 0.0, 1.0},
      {"read-noise", &o.read_noise, "X", "Noise in the dark, standard deviation [grey levels]", "",
       0.0, 100.0},
      {"shot-noise", &o.shot_noise, "X", "Variance of the noise per grey level of signal", "", 0.0,
       100.0},
      {"motion-blur", &o.motion_blur_ms, "X", "Exposure time centred on the stamp [ms]; 0: none",
       "", 0.0, 1000.0},
      {"readout", &o.readout_s, "X",
       "Rolling shutter: time from the first row to the last, the stamp being that of the middle "
       "row [s]; 0: that of --config",
       "", 0.0, 0.1},
      {"threads", &o.threads, "N", "Threads of POV-Ray", "", 1, 512},
      {"seed", &o.seed, "N", "Seed of everything random; equal seeds give equal files", "", 0.0,
       kMaxSeed},
      {"povray", &o.povray, "PROGRAM", "POV-Ray 3.7, by name or path", ""},
      {"out", &o.out, "DIR", "Folder for the sequence: DIR/mav0", ""},
      {"bag", &o.bag, "FILE", "Write a rosbag as well", ""},
      {"quiet", &o.quiet, "", "No progress bar and no summary", ""},
  };
}

std::string checkSimulateOptions(const SimulateOptions& o) {
  const int sources =
      (o.csv.empty() ? 0 : 1) + (o.builtin.empty() ? 0 : 1) + (o.recorded.empty() ? 0 : 1);
  if (sources == 0) return "one of --csv FILE, --builtin NAME and --recorded DIR is needed";
  if (sources > 1) return "--csv, --builtin and --recorded exclude each other";
  return "";
}

}  // namespace slim_init::tools
