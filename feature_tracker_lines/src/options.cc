// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
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

std::string PointTrackerOptions::validate() const {
  std::string sentence = RangeCheck()
                             .within("max_points", max_points, 8, 10000)
                             .within("min_distance_px", min_distance_px, 3.0, 1000.0)
                             .within("corner_noise_factor", corner_noise_factor, 0.1, 1e4)
                             .within("window_px", window_px, 5, 101)
                             .within("levels", levels, 0, 8)
                             .within("forward_backward_px", forward_backward_px, 0.01, 100.0)
                             .within("epipolar_px", epipolar_px, 0.01, 100.0)
                             .within("border_px", border_px, 1.0, 200.0)
                             .sentence();
  if (sentence.empty() && window_px % 2 == 0) {
    sentence = "window_px is " + std::to_string(window_px) + ", must be odd";
  }
  return sentence;
}

std::string LineTrackerOptions::validate() const {
  return RangeCheck()
      .within("max_lines", max_lines, 1, 1000)
      .within("min_length_px", min_length_px, 10.0, 1e4)
      .within("samples", samples, 3, 100)
      .within("max_distance_px", max_distance_px, 0.1, 50.0)
      .within("max_angle_deg", max_angle_deg, 0.1, 45.0)
      .within("min_overlap", min_overlap, 0.01, 1.0)
      .within("max_missed", max_missed, 0, 1000)
      .within("max_refit_rms_px", max_refit_rms_px, 0.05, 10.0)
      .sentence();
}

std::string FrontEndOptions::validate() const {
  return RangeCheck()
      .within("front_end.max_rotation_sigma_px", max_rotation_sigma_px, 1e-3, 100.0)
      .nested("points", points.validate())
      .nested("lines", lines.validate())
      .nested("vanishing_point", vanishing_point.validate())
      .sentence();
}

}  // namespace slim_init::feature_tracker_lines
