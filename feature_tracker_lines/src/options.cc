// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The table of the front end's options.
#include "slim_init/feature_tracker_lines/options.h"

#include "data/range_check.h"

namespace slim_init::feature_tracker_lines {

const char* toString(TrackerProfile profile) {
  switch (profile) {
    case TrackerProfile::kDefault: return "default";
    case TrackerProfile::kVins: return "vins";
  }
  return "unknown";
}

OptionTable optionTable(HostFrontEnd* o) {
  return {
      userKey("max_cnt", &o->max_cnt, {1, 10000}, "", "points tracked in one image"),
      userKey("min_dist", &o->min_dist, {0, 1000}, "px", "minimum distance between two points"),
      userKey("freq", &o->freq, {0, 1000}, "Hz", "rate of published features; 0 is every image"),
      userKey("F_threshold", &o->F_threshold, {0.01, 100.0}, "px", "outlier threshold"),
      userKey("equalize", &o->equalize,
              "1: histogram equalization; the default profile brightens dark images only"),
      userKey("fisheye", &o->fisheye,
              "1: only the image circle is used, or what a mask leaves; read in both profiles"),
  };
}

OptionTable optionTable(PointTrackerOptions* o) {
  return {
      userKey(
          "max_points", &o->max_points, {8, 10000}, "",
          "points tracked in one image, as many as VINS-Mono; 200 cost a third more time without "
          "gain"),
      userKey("min_distance_px", &o->min_distance_px, {3.0, 1000.0}, "px",
              "minimum distance between two points, in the camera's image"),
      advancedKey("corner_noise_factor", &o->corner_noise_factor, {0.1, 1e4}, "",
                  "a corner's smaller eigenvalue has to exceed this multiple of the largest one "
                  "from image noise alone: blank walls have no corners"),
      advancedKey("window_px", &o->window_px, {5, 101}, "px",
                  "side of the tracked patch, odd; 21 as VINS-Mono"),
      advancedKey("levels", &o->levels, {0, 8}, "",
                  "pyramid levels above the image; 3 as VINS-Mono"),
      advancedKey(
          "epipolar_px", &o->epipolar_px, {0.01, 100.0}, "px",
          "a point further from its epipolar line is an outlier; above twice the largest tracking "
          "error between neighbouring images, below half a period of common textures"),
  };
}

OptionTable optionTable(LineTrackerOptions* o) {
  return {
      userKey("enabled", &o->enabled, "0: points only"),
      userKey("max_lines", &o->max_lines, {1, 1000}, "",
              "lines tracked in one image; old and long ones are kept"),
      advancedKey("min_length_px", &o->min_length_px, {10.0, 1e4}, "px",
                  "shorter segments are discarded"),
  };
}

OptionTable optionTable(FrontEndOptions* o) {
  const OptionWord profile =
      wordOption<TrackerProfile>(&o->profile, {TrackerProfile::kDefault, TrackerProfile::kVins});
  OptionTable table;
  appendSection(
      "front_end",
      {userKey("profile", profile,
               "vins: points as VINS-Mono tracks them, with its keys max_cnt, min_dist, freq, "
               "F_threshold and equalize"),
       advancedKey("use_gyro", &o->use_gyro,
                   "predict the flow from the gyroscope (profile default); 0 for a camera alone")},
      {}, &table);
  appendSection("points", optionTable(&o->points), {}, &table);
  appendSection("lines", optionTable(&o->lines), {}, &table);
  return table;
}

std::string HostFrontEnd::validate() const { return RangeCheck::of(*this).message(); }

std::string PointTrackerOptions::validate() const {
  const std::string message = RangeCheck::of(*this).message();
  if (message.empty() && window_px % 2 == 0) {
    return "window_px is " + std::to_string(window_px) + ", must be odd";
  }
  return message;
}

std::string LineTrackerOptions::validate() const { return RangeCheck::of(*this).message(); }

std::string FrontEndOptions::validate() const {
  return RangeCheck::of(*this)
      .nested("points", points.validate())
      .nested("window", window.validate())
      .nested("imu", imu.validate())
      .message();
}

}  // namespace slim_init::feature_tracker_lines
