// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Parameters of the front end; bounds and reasons stand in the table in src/options.cc. Pixels are
// those of the image that is tracked (a large one is halved, docs/ros.md), except in
// min_distance_px.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "slim_init/option_table.h"
#include "slim_init/options.h"
#include "slim_init/types.h"

namespace slim_init::feature_tracker_lines {

/// Front-end keys of the host's file, under the host's names. Profile `vins` works by them; the
/// default profile takes only `fisheye` and `equalize`.
struct HostFrontEnd {
  int max_cnt = 150;         ///< points tracked in one image
  int min_dist = 30;         ///< distance between two points [px]
  int freq = 10;             ///< rate of published features; 0 is every image [Hz]
  double F_threshold = 1.0;  ///< of the host's outlier rejection [px]
  bool equalize = true;      ///< `vins`: histogram; default: dark images
  bool fisheye = false;      ///< only the image circle is used, or FrontEndOptions::mask

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// How points are tracked.
enum class TrackerProfile {
  kDefault,  ///< ours: absolute corner threshold, gyro-predicted flow, known-rotation RANSAC
  kVins,     ///< as VINS-Mono's feature tracker does it, parameters from HostFrontEnd
};

/// The name in a configuration file: "default", "vins".
const char* toString(TrackerProfile profile);

/// Points of the default profile: Shi-Tomasi corners, pyramidal KLT.
struct PointTrackerOptions {
  int max_points = 150;              ///< tracked in one image
  double min_distance_px = 20.0;     ///< distance between two points in the camera's image [px]
  double corner_noise_factor = 2.0;  ///< minimum corner, over what image noise alone makes
  int window_px = 21;                ///< side of the tracked patch, odd [px]
  int levels = 3;                    ///< pyramid levels above the image
  double epipolar_px = 1.5;          ///< largest distance to the epipolar line [px]

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Line segments: detection, tracking, refit.
struct LineTrackerOptions {
  bool enabled = true;          ///< false: points only
  int max_lines = 80;           ///< tracked in one image
  double min_length_px = 40.0;  ///< minimum length of a segment [px]

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// All options of an ImageFrontEnd.
struct FrontEndOptions {
  TrackerProfile profile = TrackerProfile::kDefault;  ///< how points are tracked
  bool use_gyro = true;                               ///< predict the flow from the gyroscope
  PointTrackerOptions points;                         ///< point tracker of the default profile
  LineTrackerOptions lines;                           ///< line tracker
  /// Of the IMU and the frames behind the gyroscope bias estimate. No keys of their own:
  /// loadConfig() copies those of the initializer. Of `window` the bounds on gaps are used; the
  /// estimate itself works on a short window, for an early estimate.
  WindowOptions window;
  ImuLimits imu;
  HostFrontEnd host;  ///< the host's own keys
  /// Where points and ends of lines may be: not zero (CV_8UC1 of the camera's size), in place of
  /// the image circle of HostFrontEnd::fisheye. Empty: no mask. Read by loadConfig() from the files
  /// that `mask` and `fisheye_mask` name.
  cv::Mat mask;

  /// Returns an empty string, or a message naming the field (with its section: "points.levels"),
  /// its value and the violated bound.
  std::string validate() const;
};

/// The tables of these structs, bound to the fields of the argument (slim_init/option_table.h).
/// That of FrontEndOptions has the sections front_end, points and lines; that of HostFrontEnd has
/// the host's keys.
OptionTable optionTable(HostFrontEnd* options);
OptionTable optionTable(PointTrackerOptions* options);
OptionTable optionTable(LineTrackerOptions* options);
OptionTable optionTable(FrontEndOptions* options);

}  // namespace slim_init::feature_tracker_lines
