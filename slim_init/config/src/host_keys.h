// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The keys of the host's own file. The tables here are read by loadConfig(), and the shipped YAML
// files are made from them.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "slim_init/config/config.h"

namespace slim_init::config {

/// Ours at the top level of the file: what a patched host does with slim_init.
OptionTable switchTable(HostKeys* host);

/// The host's own scalar keys that slim_init reads: topics, how far the calibration is to be
/// trusted, time offset, rolling shutter, gravity, masks.
OptionTable rigTable(Config* config);

/// Keys that VINS-Mono reads and slim_init does not, with values that suit the template. VINS-Mono
/// takes an absent number as 0.
struct VinsMonoKeys {
  double acc_n = 0.08, gyr_n = 0.004, acc_w = 0.00004, gyr_w = 2.0e-6;
  double max_solver_time = 0.04;
  int max_num_iterations = 8;
  double keyframe_parallax = 10.0;
  std::string output_path = "/tmp";
  std::string camera_name = "camera";
  bool show_track = false;
  bool loop_closure = false;
  bool load_previous_pose_graph = false;
  bool fast_relocalization = false;
  std::string pose_graph_save_path = "/tmp";
  bool save_image = false;
  bool visualize_imu_forward = false;
  double visualize_camera_size = 0.4;
};

/// Their table; without ranges, because slim_init does not check them.
OptionTable vinsMonoTable(VinsMonoKeys* keys);

/// Reads the keys of switchTable() and the host's folder for results. Throws a Problem
/// (yaml_value.h).
void readHostKeys(const cv::FileNode& root, HostKeys* host);

/// Reads everything that we take from the host's file `path`, before our section: if the host
/// estimates td or the extrinsic, the standard deviations of Calibration::sigmas are raised, and
/// our section may set them otherwise. Throws a Problem (yaml_value.h).
void readHost(const cv::FileNode& root, const std::string& path, Config* config);

/// After our section was read: a rotation that is absent has to be unknown. Throws a Problem
/// (yaml_value.h).
void checkExtrinsic(const Config& config);

/// Reads the images named by `mask` and, with fisheye: 1, by `fisheye_mask` (without that key the
/// file fisheye_mask.jpg beside `path` or one folder up, as VINS-Mono keeps it) into
/// FrontEndOptions::mask. A pixel is used if it has at least half of the image's largest grey
/// level. Throws a Problem naming file and sizes.
void readMask(const std::string& path, Config* config);

}  // namespace slim_init::config
