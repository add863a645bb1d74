// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/baselines/baselines.h"

#include "openvins.h"
#include "vins.h"
#include "window/range_check.h"

namespace slim_init::baselines {

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
      .nested("vins", vins.validate())
      .nested("openvins", openvins.validate())
      .sentence();
}

const std::vector<std::string>& baselineNames() {
  static const std::vector<std::string> kNames = {"vins", "openvins"};
  return kNames;
}

std::unique_ptr<WindowSolver> makeBaseline(const std::string& name,
                                           const InitializerOptions& initializer,
                                           const BaselineOptions& options, std::string* error) {
  std::string sentence = initializer.validate();
  if (sentence.empty()) sentence = options.validate();
  if (sentence.empty()) {
    if (name == "vins") return std::make_unique<Vins>(options.vins, initializer.gates);
    if (name == "openvins") return std::make_unique<OpenVins>(options.openvins, initializer.gates);
    sentence = "unknown method \"" + name + "\", known are:";
    for (const std::string& known : baselineNames()) sentence += " " + known;
  }
  if (error != nullptr) *error = sentence;
  return nullptr;
}

}  // namespace slim_init::baselines
