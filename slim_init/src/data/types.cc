// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/types.h"

#include <cmath>

#include "data/range_check.h"
#include "geometry/so3.h"
#include "slim_init/option_table.h"
#include "slim_init/state_prior.h"
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

std::string ImuNoise::validate() const { return RangeCheck::of(*this).message(); }

std::string CalibrationSigmas::validate() const { return RangeCheck::of(*this).message(); }

std::string ImuBiases::validate() const {
  // [rad/s], [m/s^2]: the ranges of the priors in InertialOptions, which take their place.
  return RangeCheck()
      .within("norm of gyro", gyro.norm(), 0.0, 10.0)
      .within("norm of accel", accel.norm(), 0.0, 10.0)
      .within("gyro_sigma", gyro_sigma, 1e-6, HUGE_VAL)
      .within("accel_sigma", accel_sigma, 1e-6, HUGE_VAL)
      .message();
}

std::string SpeedSensor::validate() const {
  return RangeCheck()
      .within("distance of R_b_s from a rotation", distanceFromRotation(R_b_s), 0.0,
              kRotationTolerance)
      .within("norm of t_b_s", t_b_s.norm(), 0.0, 20.0)
      .within("scale_sigma", scale_sigma, 1e-4, 0.5)
      .within("lateral_sigma", lateral_sigma, 0.0, 10.0)
      .message();
}

SpeedSample SpeedSample::forward(double t, double speed, double sigma) {
  SpeedSample sample;
  sample.t = t;
  sample.velocity.x() = speed;
  // The square of a negative one would look like a variance.
  sample.covariance(0, 0) = sigma > 0.0 ? sigma * sigma : sigma;
  sample.forward_only = true;
  return sample;
}

std::string Calibration::validate() const {
  Calibration copy = *this;
  return RangeCheck()
      .nested("imu_noise", imu_noise.validate())
      .nested("sigmas", sigmas.validate())
      .nested("imu_biases", imu_biases.validate())
      .within("gravity_magnitude", gravity_magnitude, 9.7, 9.9)
      .within("focal_px", focal_px, 10.0, 1e5)
      .within(optionTable(&copy))
      .within("td", td, -1.0, 1.0)
      .within("readout_s", readout_s, 0.0, 0.2)
      .within("norm of t_b_c", t_b_c.norm(), 0.0, 10.0)
      .within("distance of R_b_c from a rotation", distanceFromRotation(R_b_c), 0.0,
              kRotationTolerance)
      .nested("speed_sensor", speed_sensor.validate())
      .message();
}

bool NavState::isFinite() const {
  return std::isfinite(t) && R_w_b.allFinite() && p_w_b.allFinite() && v_w_b.allFinite() &&
         gyro_bias.allFinite() && accel_bias.allFinite();
}

bool ImuLimits::exceededBy(const ImuSample& sample) const {
  return sample.accel.allFinite() && sample.gyro.allFinite() &&
         (sample.accel.cwiseAbs().maxCoeff() > max_accel ||
          sample.gyro.cwiseAbs().maxCoeff() > max_gyro);
}

std::string ImuLimits::describe(const ImuSample& sample) const {
  return roundedText(3, sample.accel.cwiseAbs().maxCoeff(), " m/s^2 and ",
                     sample.gyro.cwiseAbs().maxCoeff(), " rad/s on an axis (limits ", max_accel,
                     " m/s^2, ", max_gyro, " rad/s)");
}

std::string ImuLimits::validate() const { return RangeCheck::of(*this).message(); }

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
