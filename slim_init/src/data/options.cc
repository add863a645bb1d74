// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/options.h"

#include "data/range_check.h"

namespace slim_init {

std::string WindowOptions::validate() const {
  return RangeCheck()
      .within("keyframes", keyframes, kMinKeyframes, 50)
      .within("min_keyframes", min_keyframes, kMinKeyframes, 50)
      .ordered("min_keyframes", min_keyframes, "keyframes", keyframes)
      .within("min_interval_s", min_interval_s, 0.01, 5.0)
      .within("max_frame_gap_s", max_frame_gap_s, 0.05, 10.0)
      .within("max_imu_gap_s", max_imu_gap_s, 0.001, 1.0)
      .within("buffer_s", buffer_s, 0.5, 600.0)
      // Frames come at their own pace, so that keyframes lie up to twice as far apart.
      .ordered("twice the least length of a full window", 2.0 * (keyframes - 1) * min_interval_s,
               "buffer_s", buffer_s)
      .sentence();
}

std::string MultiGapBiasOptions::validate() const {
  return RangeCheck()
      .within("max_gap", max_gap, 1, 8)
      .within("min_points_per_pair", min_points_per_pair, 5, 1000)
      .within("max_iterations", max_iterations, 1, 1000)
      .within("cauchy_sigmas", cauchy_sigmas, 0.1, 1e6)
      .within("vp_inflation", vp_inflation, 0.1, 1e6)
      .within("bias_prior", bias_prior, 1e-4, 10.0)
      .within("max_bias", max_bias, 1e-3, 10.0)
      .sentence();
}

std::string TrackPruningOptions::validate() const {
  return RangeCheck()
      .within("threshold_sigmas", threshold_sigmas, 0.5, 100.0)
      .within("min_points_per_pair", min_points_per_pair, 5, 1000)
      .within("hypotheses", hypotheses, 1, 1000)
      .sentence();
}

std::string RobustBiasOptions::validate() const {
  return RangeCheck()
      .nested("refinement", refinement.validate())
      .nested("pruning", pruning.validate())
      .within("candidates", candidates, 0, 1000)
      .within("clean_inlier_fraction", clean_inlier_fraction, 0.0, 1.0)
      .within("clean_cost", clean_cost, 0.0, 10.0)
      .within("min_inlier_fraction", min_inlier_fraction, 0.0, 1.0)
      .within("gyro_noise_inflation", gyro_noise_inflation, 0.0, 1e3)
      .sentence();
}

std::string ReverseAlignmentOptions::validate() const {
  return RangeCheck()
      .within("accel_bias_prior", accel_bias_prior, 1e-6, 10.0)
      .within("min_scale", min_scale, 1e-6, 1e3)
      .within("max_scale", max_scale, 1e-3, 1e6)
      .ordered("min_scale", min_scale, "max_scale", max_scale)
      .within("grid", grid, 3, 10000)
      .within("length_weight", length_weight, 1.0, 1e9)
      .within("log_scale_tolerance", log_scale_tolerance, 1e-12, 0.1)
      .sentence();
}

std::string RefinementOptions::validate() const {
  return RangeCheck()
      .within("max_iterations", max_iterations, 0, 1000)
      .within("tolerance", tolerance, 1e-30, 100.0)
      .within("cauchy_sigmas", cauchy_sigmas, 0.5, 1e6)
      .within("accel_bias_prior", accel_bias_prior, 1e-6, 10.0)
      .within("gyro_bias_prior", gyro_bias_prior, 1e-6, 10.0)
      .within("vp_inflation", vp_inflation, 0.1, 1e4)
      .within("accel_noise_factor", accel_noise_factor, 1.0, 100.0)
      .within("gyro_noise_factor", gyro_noise_factor, 1.0, 100.0)
      .within("min_sigma_px", min_sigma_px, 0.01, 10.0)
      .within("reject_sigmas", reject_sigmas, 1.0, 100.0)
      .within("min_reject_px", min_reject_px, 0.01, 100.0)
      .within("min_line_views", min_line_views, 2, 15)
      .within("line_agreement_sigmas", line_agreement_sigmas, 1.0, 1e3)
      .within("suspicious_chi2", suspicious_chi2, 0.0, 1e6)
      .sentence();
}

std::string VanishingPointOptions::validate() const {
  return RangeCheck()
      .within("icosphere_subdivisions", icosphere_subdivisions, 1, 6)
      .within("vote_threshold_deg", vote_threshold_deg, 0.1, 20.0)
      .within("inlier_threshold_deg", inlier_threshold_deg, 0.1, 20.0)
      .within("min_inliers", min_inliers, 2, 1000)
      .within("match_threshold_deg", match_threshold_deg, 0.1, 45.0)
      .within("min_track_age", min_track_age, 1, 100)
      .within("consistency_threshold_deg", consistency_threshold_deg, 0.01, 20.0)
      // The rms over lines chosen by a threshold is always below that threshold.
      .ordered("consistency_threshold_deg", consistency_threshold_deg, "inlier_threshold_deg",
               inlier_threshold_deg)
      .sentence();
}

std::string AlignmentOptions::validate() const {
  return RangeCheck()
      .within("min_track_length", min_track_length, 3, 50)
      .within("min_tracks", min_tracks, 1, 10000)
      .within("min_parallax_rad", min_parallax_rad, 0.0, 0.1)
      .sentence();
}

std::string SlimOptions::validate() const {
  if (!reverse_start && !tight_start)
    return "reverse_start and tight_start are both off, needs one";
  return RangeCheck().within("few_tracks", few_tracks, 0, 100000).sentence();
}

std::string GateOptions::validate() const {
  return RangeCheck()
      .within("min_parallax_px", min_parallax_px, 0.0, 1e3)
      .within("min_rotation_deg", min_rotation_deg, 0.0, 180.0)
      .within("min_excitation", min_excitation, 0.0, 100.0)
      .within("min_linkage", min_linkage, 1.0, 1e12)
      .within("max_alignment_residual", max_alignment_residual, 0.0, 1e3)
      .within("max_rest_deviation", max_rest_deviation, 0.0, 100.0)
      .within("max_chi2", max_chi2, 0.1, 1e6)
      .within("min_inlier_fraction", min_inlier_fraction, 0.0, 1.0)
      .within("min_point_spread_deg", min_point_spread_deg, 0.0, 90.0)
      .within("max_inertial_chi2", max_inertial_chi2, 0.0, 1e6)
      .within("max_inertial_chi2_short", max_inertial_chi2_short, 0.0, 1e6)
      .within("max_extrinsic_error_deg", max_extrinsic_error_deg, 0.0, 180.0)
      .within("max_td_error_s", max_td_error_s, 0.0, 1.0)
      .within("max_behind_fraction", max_behind_fraction, 0.0, 1.0)
      .within("max_scale_sigma", max_scale_sigma, 0.0, 10.0)
      .sentence();
}

std::string InitializerOptions::validate() const {
  return RangeCheck()
      .nested("imu", imu.validate())
      .nested("window", window.validate())
      .nested("vanishing_point", vanishing_point.validate())
      .nested("alignment", alignment.validate())
      .nested("robust_bias", robust_bias.validate())
      .nested("reverse_alignment", reverse_alignment.validate())
      .nested("refinement", refinement.validate())
      .nested("slim", slim.validate())
      .nested("gates", gates.validate())
      .sentence();
}

}  // namespace slim_init
