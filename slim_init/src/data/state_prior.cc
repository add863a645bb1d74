// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/state_prior.h"

#include <cmath>

#include "geometry/so3.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

// Share of the diagonal.
constexpr double kSymmetry = 1e-6;

bool isRotation(const Eigen::Matrix3d& R) { return distanceFromRotation(R) < kRotationTolerance; }

std::string checkCalibration(const OptionalCalibration& calibration, const char* whose) {
  if (!calibration.has_value() ||
      (calibration->R_b_c.allFinite() && calibration->t_b_c.allFinite() &&
       std::isfinite(calibration->td) && calibration->covariance.allFinite() &&
       isRotation(calibration->R_b_c))) {
    return "";
  }
  return std::string("the calibration of ") + whose + " is not finite, or no rotation";
}

}  // namespace

std::string StatePrior::validate() const {
  if (!state.isFinite()) return "the last healthy state is not finite";
  if (!isRotation(state.R_w_b)) {
    return "R_w_b of the last healthy state is not a rotation to within 1e-3";
  }
  if (!covariance.allFinite()) return "the covariance of the last healthy state is not finite";
  if (const double least = covariance.diagonal().minCoeff(); least < 0.0) {
    return text("the covariance of the last healthy state has ", least,
                " on its diagonal (minimum 0)");
  }
  if (!((covariance - covariance.transpose()).norm() <= kSymmetry * covariance.norm())) {
    return "the covariance of the last healthy state is not symmetric";
  }
  return checkCalibration(calibration, "the last healthy state");
}

bool KnownSensors::empty() const {
  return !calibration.has_value() && !std::isfinite(biases.gyro_sigma) &&
         !std::isfinite(biases.accel_sigma);
}

std::string KnownSensors::validate() const {
  if (const std::string message = biases.validate(); !message.empty()) {
    return "the known biases: " + message;
  }
  return checkCalibration(calibration, "the known sensors");
}

}  // namespace slim_init
