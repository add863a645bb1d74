// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "ov_core.h"

namespace ov_init {

struct InertialInitializerOptions {
  bool init_dyn_use = false;
  Eigen::Vector3d init_dyn_bias_a = Eigen::Vector3d::Zero();
  double sigma_w = 0.0;
  double sigma_a = 0.0;
  double gravity_mag = 9.81;
  double calib_camimu_dt = 0.0;
  std::unordered_map<std::size_t, std::shared_ptr<ov_core::CamBase>> camera_intrinsics;
  std::map<std::size_t, Eigen::VectorXd> camera_extrinsics;

  void print_and_load_initializer(const std::shared_ptr<ov_core::YamlParser>& parser = nullptr) {
    if (parser != nullptr) {
      parser->parse_config("init_dyn_use", init_dyn_use);
    }
  }
};

}  // namespace ov_init
