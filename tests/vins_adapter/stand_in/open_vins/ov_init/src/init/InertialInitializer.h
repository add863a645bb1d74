// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "init/InertialInitializerOptions.h"

namespace ov_init {

class InertialInitializer {
 public:
  // clang-format off
  explicit InertialInitializer(InertialInitializerOptions &params_, std::shared_ptr<ov_core::FeatureDatabase> db);
  // clang-format on
  void feed_imu(const ov_core::ImuData& message, double oldest_time = -1);
  bool initialize(double& timestamp, Eigen::MatrixXd& covariance,
                  std::vector<std::shared_ptr<ov_type::Type>>& order,
                  std::shared_ptr<ov_type::IMU> t_imu, bool wait_for_jerk = true);

  // What the test plays, and what was seen.
  bool playDynamic(double& timestamp, Eigen::MatrixXd& covariance,
                   std::vector<std::shared_ptr<ov_type::Type>>& order,
                   std::shared_ptr<ov_type::IMU> t_imu);
  bool at_rest = false, dynamic_succeeds = false;
  double dynamic_time = 0.0;
  Eigen::MatrixXd dynamic_state = Eigen::MatrixXd::Zero(16, 1);
  int static_tries = 0, dynamic_tries = 0;

 private:
  InertialInitializerOptions params;
  std::shared_ptr<std::vector<ov_core::ImuData>> imu_data;
};

}  // namespace ov_init
