// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "InertialInitializer.h"

#include "types/Type.h"

using namespace ov_init;

namespace ov_core {
char line[2000];
std::vector<std::string> printed;
void print() { printed.push_back(line); }
}  // namespace ov_core

InertialInitializer::InertialInitializer(InertialInitializerOptions &params_, std::shared_ptr<ov_core::FeatureDatabase>)
    : params(params_) {
  imu_data = std::make_shared<std::vector<ov_core::ImuData>>();
}

void InertialInitializer::feed_imu(const ov_core::ImuData &message, double) {
  imu_data->emplace_back(message);
}

bool InertialInitializer::initialize(double &timestamp, Eigen::MatrixXd &covariance,
                                     std::vector<std::shared_ptr<ov_type::Type>> &order,
                                     std::shared_ptr<ov_type::IMU> t_imu, bool) {
  double newest_cam_time = -1;
  if (at_rest) {
    ++static_tries;
    timestamp = newest_cam_time;
    return true;
  } else if (params.init_dyn_use) {
    std::map<double, std::shared_ptr<ov_type::PoseJPL>> _clones_IMU;
    ++dynamic_tries;
    if (!dynamic_succeeds) return false;
    return playDynamic(timestamp, covariance, order, t_imu);
  }
  return false;
}
