// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/baselines/options.h"

#include "data/range_check.h"

namespace slim_init::baselines {

std::string GyroBiasOptions::validate() const {
  return RangeCheck()
      .within("max_iterations", max_iterations, 1, 1000)
      .within("max_relinearizations", max_relinearizations, 1, 20)
      .within("cauchy_scale", cauchy_scale, 1e-12, 1e6)
      .within("min_points_per_pair", min_points_per_pair, 5, 1000)
      .within("max_bias", max_bias, 1e-3, 10.0)
      .sentence();
}

std::string LineSelectionOptions::validate() const {
  return RangeCheck()
      .within("min_keyframes", min_keyframes, 2, 50)
      .within("max_lines_per_pair", max_lines_per_pair, 0, 1000)
      .within("full_length_px", full_length_px, 1.0, 1e5)
      .sentence();
}

std::string SlimPaperOptions::validate() const {
  return RangeCheck()
      .within("vp_weight", vp_weight, 0.0, 1e6)
      .within("vp_cauchy_scale", vp_cauchy_scale, 1e-9, 10.0)
      .within("line_epipolar_weight", line_epipolar_weight, 0.0, 1e6)
      .within("line_normal_weight", line_normal_weight, 0.0, 1e6)
      .sentence();
}

std::string DrtViBaOptions::validate() const {
  return RangeCheck()
      .within("sigma_px", sigma_px, 1e-3, 1e3)
      .within("huber_sigmas", huber_sigmas, 1e-3, 1e6)
      .within("max_iterations", max_iterations, 1, 1000)
      .within("tolerance", tolerance, 0.0, 1.0)
      .sentence();
}

std::string VinsOptions::validate() const {
  return RangeCheck()
      .within("tracking_threshold_px", tracking_threshold_px, 0.0, 1e3)
      .within("min_common_points", min_common_points, 5, 10000)
      .within("min_parallax_px", min_parallax_px, 0.0, 1e4)
      .within("ransac_threshold_px", ransac_threshold_px, 1e-3, 1e3)
      .within("ransac_confidence", ransac_confidence, 0.5, 1.0 - 1e-9)
      .within("min_pose_inliers", min_pose_inliers, 5, 10000)
      .within("min_pnp_points", min_pnp_points, 6, 10000)
      .within("max_iterations", max_iterations, 1, 1000)
      .within("max_final_cost", max_final_cost, 0.0, 1e6)
      .within("max_gravity_residual", max_gravity_residual, 0.0, 100.0)
      .sentence();
}

std::string OpenVinsOptions::validate() const {
  return RangeCheck()
      .within("max_features", max_features, 0, 100000)
      .within("min_features", min_features, 4, 10000)
      .within("min_rotation_deg", min_rotation_deg, 0.0, 1e4)
      .within("sigma_px", sigma_px, 1e-3, 1e3)
      .within("cauchy_sigmas", cauchy_sigmas, 1e-3, 1e6)
      .within("gyro_bias_prior", gyro_bias_prior, 1e-6, 1e3)
      .within("accel_bias_prior", accel_bias_prior, 1e-6, 1e3)
      .within("gyro_walk", gyro_walk, 1e-9, 1.0)
      .within("accel_walk", accel_walk, 1e-9, 1.0)
      .within("max_iterations", max_iterations, 0, 1000)
      .within("relinearizations", relinearizations, 0, 10)
      .within("function_tolerance", function_tolerance, 0.0, 1.0)
      .sentence();
}

std::string BaselineOptions::validate() const {
  return RangeCheck()
      .nested("gyro_bias", gyro_bias.validate())
      .nested("line_selection", line_selection.validate())
      .nested("slim_paper", slim_paper.validate())
      .nested("drt_vi_ba", drt_vi_ba.validate())
      .nested("vins", vins.validate())
      .nested("openvins", openvins.validate())
      .sentence();
}

}  // namespace slim_init::baselines
