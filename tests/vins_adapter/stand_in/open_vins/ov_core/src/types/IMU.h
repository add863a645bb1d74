// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "ov_core.h"

namespace ov_type {

class IMU : public Type {
 public:
  void set_value(const Eigen::MatrixXd& new_value) { estimate = new_value; }
  void set_fej(const Eigen::MatrixXd& new_value) { first_estimate = new_value; }
  Eigen::MatrixXd value() { return estimate; }
  Eigen::MatrixXd estimate = Eigen::MatrixXd::Zero(16, 1);
  Eigen::MatrixXd first_estimate = Eigen::MatrixXd::Zero(16, 1);
};

}  // namespace ov_type
