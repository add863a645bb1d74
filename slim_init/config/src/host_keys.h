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

/// Reads the keys of switchTable() and the host's folder for results. Throws a Problem
/// (yaml_value.h).
void readHostKeys(const cv::FileNode& root, HostKeys* host);

/// Reads everything that we take from the host's file `path`, before our section: if the host
/// estimates td or the extrinsic, the standard deviations of Calibration::sigmas are raised, and
/// our section may set them otherwise. Throws a Problem (yaml_value.h).
void readHost(const cv::FileNode& root, const std::string& path, Config* config);

/// The rotation nearest to `R`: files carry a few digits. Throws a Problem (yaml_value.h) about
/// what was not meant as one.
Eigen::Matrix3d nearestRotation(const char* key, const Eigen::Matrix3d& R);

/// After our section was read: a rotation that is absent has to be unknown. Throws a Problem
/// (yaml_value.h).
void checkExtrinsic(const Config& config);

/// Reads the images named by `mask` and, with fisheye: 1, by `fisheye_mask` (without that key the
/// file fisheye_mask.jpg beside `path` or one folder up, as VINS-Mono keeps it) into
/// FrontEndOptions::mask. A pixel is used if it has at least half of the image's largest grey
/// level. Throws a Problem naming file and sizes.
void readMask(const std::string& path, Config* config);

}  // namespace slim_init::config
