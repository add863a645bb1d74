// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The table of the compared methods' options.
#include "slim_init/baselines/options.h"

#include "data/range_check.h"

namespace slim_init::baselines {
namespace {

const std::vector<std::string> kWithLigt = {"slim-paper", "drt-l", "drt-t", "drt-vi-ba"};

}  // namespace

OptionTable optionTable(GyroBiasOptions* o) {
  return {
      advancedKey("max_iterations", &o->max_iterations, {1, 1000}, "",
                  "Levenberg-Marquardt iterations per linearisation of the IMU"),
      advancedKey("max_relinearizations", &o->max_relinearizations, {1, 20}, "",
                  "integrations of the gyroscope at a new bias"),
      advancedKey("cauchy_scale", &o->cauchy_scale, {1e-12, 1e6}, "rad^2",
                  "residual of a keyframe pair beyond which it loses weight; DRT's release"),
      advancedKey("min_points_per_pair", &o->min_points_per_pair, {5, 1000}, "",
                  "keyframe pairs with fewer common points are not used"),
      advancedKey("max_bias", &o->max_bias, {1e-3, 10.0}, "rad/s",
                  "a larger estimate is a numerical failure"),
  };
}

OptionTable optionTable(AlignmentGateOptions* o) {
  return {
      advancedKey("min_linkage", &o->min_linkage, {1.0, 1e12}, "",
                  "minimum ratio of the second to the first eigenvalue of the translation system: "
                  "the tracks link the window",
                  kWithLigt),
      advancedKey("max_alignment_residual", &o->max_alignment_residual, {0.0, 1e3}, "m, m/s",
                  "maximum rms residual of the velocity and position rows over the window",
                  {"slim-paper", "drt-l", "drt-t", "drt-vi-ba", "vins"}),
  };
}

OptionTable optionTable(LineSelectionOptions* o) {
  return {
      advancedKey("min_keyframes", &o->min_keyframes, {2, 50}, "keyframes",
                  "a line seen in fewer is not persistent and not used"),
      advancedKey("max_lines_per_pair", &o->max_lines_per_pair, {0, 1000}, "",
                  "best lines of a keyframe pair by score, for each residual type"),
      advancedKey("full_length_px", &o->full_length_px, {1.0, 1e5}, "px",
                  "length at which the length part of q^n reaches 1"),
  };
}

OptionTable optionTable(SlimPaperOptions* o) {
  return {
      advancedKey("use_vp", &o->use_vp, "vanishing points in the gyroscope bias, eq. (4)"),
      advancedKey("use_line_epipolar", &o->use_line_epipolar, "the line residual of eq. (11)"),
      advancedKey("use_line_normal", &o->use_line_normal, "the line residual of eq. (12)"),
      advancedKey("min_track_age", &o->min_track_age, {1, 100}, "keyframes",
                  "younger vanishing points are not used (A_min of the paper)"),
      advancedKey("consistency_threshold_deg", &o->consistency_threshold_deg, {0.01, 20.0}, "deg",
                  "maximum rms of the inliers (t_vp of the paper). Lines spread evenly up to "
                  "vanishing_point.inlier_threshold_deg have 0.58 of it, so this rejects a bundle "
                  "that is no vanishing point"),
      advancedKey(
          "vp_weight", &o->vp_weight, {0.0, 1e6}, "",
          "factor on lambda_vp, the ratio of point to vanishing-point residuals. At 1 the "
          "vanishing points dominate and the error of the bias grows several times, because a "
          "vanishing point is about ten times noisier than a point (docs/baselines.md)"),
      advancedKey("vp_cauchy_scale", &o->vp_cauchy_scale, {1e-9, 10.0}, "rad",
                  "vanishing-point residual beyond which it loses weight"),
      advancedKey("line_epipolar_weight", &o->line_epipolar_weight, {0.0, 1e6}, "",
                  "constant of eq. (13) for eq. (11); a larger one pulls the scale to zero, above "
                  "0.1 the success falls"),
      advancedKey("line_normal_weight", &o->line_normal_weight, {0.0, 1e6}, "",
                  "constant of eq. (13) for eq. (12); 1 is best or near it"),
  };
}

OptionTable optionTable(DrtViBaOptions* o) {
  return {
      advancedKey("sigma_px", &o->sigma_px, {1e-3, 1e3}, "px",
                  "standard deviation of an epipolar residual; VINS-Mono's"),
      advancedKey("huber_sigmas", &o->huber_sigmas, {1e-3, 1e6}, "sigma",
                  "epipolar residual beyond which it loses weight"),
      advancedKey("max_iterations", &o->max_iterations, {1, 1000}, "", "Levenberg-Marquardt steps"),
      advancedKey("tolerance", &o->tolerance, {0.0, 1.0}, "",
                  "relative decrease of the cost that ends the minimisation"),
  };
}

OptionTable optionTable(VinsOptions* o) {
  return {
      advancedKey(
          "tracking_threshold_px", &o->tracking_threshold_px, {0.0, 1e3}, "px",
          "fundamental matrix between consecutive keyframes; a track that disagrees is restarted. "
          "0: off; the release has it, at 1 px, in its tracker, and the tracks of a window come "
          "from "
          "a front end (docs/baselines.md)"),
      advancedKey("min_common_points", &o->min_common_points, {5, 10000}, "",
                  "minimum number of points common to the reference and the newest keyframe"),
      advancedKey("min_parallax_px", &o->min_parallax_px, {0.0, 1e4}, "px",
                  "minimum mean motion of these points, rotation included"),
      advancedKey("ransac_threshold_px", &o->ransac_threshold_px, {1e-3, 1e3}, "px",
                  "inlier threshold of the five-point pose"),
      advancedKey("ransac_confidence", &o->ransac_confidence, {0.5, 0.999999}, "",
                  "confidence of both consensus searches"),
      advancedKey("min_pose_inliers", &o->min_pose_inliers, {5, 10000}, "",
                  "minimum number of points in front of both cameras for the five-point pose"),
      advancedKey("min_pnp_points", &o->min_pnp_points, {6, 10000}, "",
                  "minimum number of known points to register a keyframe"),
      advancedKey("max_iterations", &o->max_iterations, {1, 1000}, "",
                  "iterations of the bundle adjustment; the release ends it by time"),
      advancedKey("max_final_cost", &o->max_final_cost, {0.0, 1e6}, "",
                  "without convergence it may still end at this cost, on the plane z = 1"),
      advancedKey("max_gravity_residual", &o->max_gravity_residual, {0.0, 100.0}, "m/s^2",
                  "maximum difference of the unconstrained |g| from its true value"),
  };
}

OptionTable optionTable(OpenVinsOptions* o) {
  return {
      advancedKey(
          "max_features", &o->max_features, {0, 100000}, "",
          "longest tracks used; 0 uses all. The release tracks 50 points in an image to save time"),
      advancedKey("min_features", &o->min_features, {4, 10000}, "",
                  "minimum number of tracks, and of points in front of the camera"),
      advancedKey("min_rotation_deg", &o->min_rotation_deg, {0.0, 1e4}, "deg",
                  "summed rotation of the gyroscope, bias included; less waits"),
      advancedKey("sigma_px", &o->sigma_px, {1e-3, 1e3}, "px",
                  "standard deviation of an observation"),
      advancedKey("cauchy_sigmas", &o->cauchy_sigmas, {1e-3, 1e6}, "sigma",
                  "residual of an observation beyond which it loses weight"),
      advancedKey("gyro_bias_prior", &o->gyro_bias_prior, {1e-6, 1e3}, "rad/s",
                  "standard deviation of the bias about zero"),
      advancedKey("accel_bias_prior", &o->accel_bias_prior, {1e-6, 1e3}, "m/s^2",
                  "standard deviation of the bias about zero"),
      advancedKey("gyro_walk", &o->gyro_walk, {1e-9, 1.0}, "rad/s^2/sqrt(Hz)",
                  "random walk of the bias"),
      advancedKey("accel_walk", &o->accel_walk, {1e-9, 1.0}, "m/s^3/sqrt(Hz)",
                  "random walk of the bias"),
      advancedKey("max_iterations", &o->max_iterations, {0, 1000}, "",
                  "iterations of the refinement; 0: off, the release also ends it at 0.05 s"),
      advancedKey("relinearizations", &o->relinearizations, {0, 10}, "",
                  "further refinements with the IMU integrated again at the refined biases; the "
                  "release has none"),
      advancedKey("function_tolerance", &o->function_tolerance, {0.0, 1.0}, "",
                  "relative decrease of the cost that ends it"),
  };
}

OptionTable optionTable(BaselineOptions* o) {
  OptionTable table;
  appendSection("alignment_gates", optionTable(&o->alignment_gates), {}, &table);
  appendSection("gyro_bias", optionTable(&o->gyro_bias), kWithLigt, &table);
  appendSection("line_selection", optionTable(&o->line_selection), {"slim-paper"}, &table);
  appendSection("slim_paper", optionTable(&o->slim_paper), {"slim-paper"}, &table);
  appendSection("drt_vi_ba", optionTable(&o->drt_vi_ba), {"drt-vi-ba"}, &table);
  appendSection("vins", optionTable(&o->vins), {"vins"}, &table);
  appendSection("openvins", optionTable(&o->openvins), {"openvins"}, &table);
  return table;
}

std::string BaselineOptions::validate() const { return RangeCheck::of(*this).message(); }

}  // namespace slim_init::baselines
