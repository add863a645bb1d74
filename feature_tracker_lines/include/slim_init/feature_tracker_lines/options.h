// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Every number of the front end, with default, unit and reason. Configuration keys are the field
// names (config/README.md).
#pragma once

#include <string>

#include "slim_init/options.h"

namespace slim_init::feature_tracker_lines {

/// Front-end keys of the host's file, under the host's names. Profile `vins` works by them; the
/// default profile takes only `fisheye`.
struct HostFrontEnd {
  int max_cnt = 150;         ///< points tracked in one image
  int min_dist = 30;         ///< [px] between two points
  int freq = 10;             ///< [Hz] of published features; 0 is every image
  double F_threshold = 1.0;  ///< [px] of the host's outlier rejection
  bool equalize = true;      ///< histogram equalization before detection
  bool fisheye = false;      ///< only the image circle is used
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
  /// Tracked in one image; VINS-Mono has as many. 200 cost a third more time and gain nothing.
  int max_points = 150;
  double min_distance_px = 20.0;  ///< between two points [px]
  /// A corner's smaller eigenvalue has to exceed this multiple of the largest one that the measured
  /// image noise alone makes: blank walls give no corners.
  double corner_noise_factor = 2.0;
  int window_px = 21;  ///< side of the tracked patch [px], odd; 21 as VINS-Mono
  int levels = 3;      ///< pyramid levels above the image; 3 as VINS-Mono
  /// A point tracked back to the image before has to come within this of where it was [px].
  double forward_backward_px = 0.5;
  /// Distance to the epipolar line above which a point is an outlier [px]. More than twice the
  /// largest tracking error between neighbouring images, less than half a period of common
  /// textures.
  double epipolar_px = 1.5;
  double border_px = 8.0;  ///< points closer to the image's edge than this are dropped [px]

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Line segments: detection, tracking, refit.
struct LineTrackerOptions {
  bool enabled = true;            ///< false: points only
  int max_lines = 80;             ///< tracked in one image; old and long ones are kept
  double min_length_px = 40.0;    ///< shorter segments are left out [px]
  int samples = 5;                ///< points per line that KLT predicts the line with
  double max_distance_px = 2.0;   ///< predicted to detected line, across [px]
  double max_angle_deg = 3.0;     ///< predicted to detected line [deg]
  double min_overlap = 0.4;       ///< of predicted and detected segment, of the shorter one
  int max_missed = 3;             ///< images without a detection over which a line is carried on
  double max_refit_rms_px = 0.5;  ///< edge samples about the fitted line; more is no line [px]

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// All options of an ImageFrontEnd.
struct FrontEndOptions {
  TrackerProfile profile = TrackerProfile::kDefault;
  /// Predict the flow from the gyroscope (default profile only); off for a camera alone.
  bool use_gyro = true;
  /// Estimate the gyroscope bias from the tracks themselves, for the prediction and for the
  /// known-rotation RANSAC. Off: only what ImageFrontEnd::setGyroBias was told.
  bool estimate_gyro_bias = true;
  /// The rotation between two images counts as known where its standard deviation moves a point by
  /// less than this [px]: well below PointTrackerOptions::epipolar_px.
  double max_rotation_sigma_px = 0.5;
  PointTrackerOptions points;
  LineTrackerOptions lines;
  /// Dominant vanishing point of the debug image and of ImageReport. Has no keys of its own:
  /// loadConfig() copies what the solvers use.
  VanishingPointOptions vanishing_point;
  HostFrontEnd host;

  /// Returns an empty string, or a sentence naming the field (with its section: "points.levels"),
  /// its value and the violated bound.
  std::string validate() const;
};

}  // namespace slim_init::feature_tracker_lines
