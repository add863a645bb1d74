// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "VioManager.h"

using namespace ov_msckf;

bool VioManager::try_to_initialize() {
  thread_init_running = true;
  {
    double timestamp = 0.0;
    Eigen::MatrixXd covariance;
    bool wait_for_jerk = true;
    bool success = initializer->initialize(timestamp, covariance, order, state->_imu, wait_for_jerk);
    if (success) {
      state->_timestamp = timestamp;
      state->_Cov = covariance;
    }
    thread_init_running = false;
    return success;
  }
}

bool ov_init::InertialInitializer::playDynamic(double &timestamp, Eigen::MatrixXd &covariance,
                                               std::vector<std::shared_ptr<ov_type::Type>> &order,
                                               std::shared_ptr<ov_type::IMU> t_imu) {
  t_imu->set_value(dynamic_state);
  timestamp = dynamic_time;
  order.assign(1, t_imu);
  covariance = Eigen::MatrixXd::Identity(15, 15);
  return true;
}
