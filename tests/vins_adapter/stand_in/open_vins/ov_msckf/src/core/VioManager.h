// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "init/InertialInitializer.h"
#include "types/IMU.h"

namespace ov_msckf {

struct State {
  std::shared_ptr<ov_type::IMU> _imu = std::make_shared<ov_type::IMU>();
  double _timestamp = -1;
  Eigen::MatrixXd _Cov;
};

class VioManager {
 public:
  explicit VioManager(ov_init::InertialInitializerOptions& params)
      : initializer(std::make_shared<ov_init::InertialInitializer>(
            params, trackFEATS->get_feature_database())) {}
  bool try_to_initialize();

  std::shared_ptr<State> state = std::make_shared<State>();
  std::shared_ptr<ov_core::TrackBase> trackFEATS = std::make_shared<ov_core::TrackBase>();
  std::shared_ptr<ov_init::InertialInitializer> initializer;
  std::vector<std::shared_ptr<ov_type::Type>> order;
  bool thread_init_running = false;
};

}  // namespace ov_msckf
