// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/calibration_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/so3.h"
#include "slim_init/baselines/baselines.h"
#include "support/chi_square.h"
#include "support/exact_window.h"
#include "support/robust_bias.h"

namespace slim_init {
namespace {

constexpr double kRadPerDeg = M_PI / 180.0;

ExactWindow exactWindow(unsigned seed, double pixel_noise, Motion motion = Motion::kExcited) {
  ExactWindowOptions options;
  options.angular_noise = true;
  options.seed = seed;
  options.pixel_noise = pixel_noise;
  options.imu_noise = pixel_noise > 0.0;
  options.motion = motion;
  return makeExactWindow(options);
}

// What a user with a wrong calibration hands over: the true extrinsic is R_b_c Exp(error), the true
// time offset td_error more than the one assumed.
std::shared_ptr<const InitWindow> miscalibrated(const ExactWindow& exact,
                                                const Eigen::Vector3d& extrinsic_error,
                                                double td_error) {
  Calibration calibration = exact.calibration;
  calibration.R_b_c = calibration.R_b_c * expSO3(-extrinsic_error);
  std::vector<FrameObservation> keyframes = exact.keyframes;
  for (FrameObservation& frame : keyframes) frame.t -= td_error;
  std::vector<ImuSample> imu = exact.imu;
  // The data reach just over the window: the outermost samples are held for what the error asks.
  if (keyframes.front().t < imu.front().t) {
    imu.insert(imu.begin(), imu.front());
    imu.front().t = keyframes.front().t;
  }
  if (keyframes.back().t > imu.back().t) {
    imu.push_back(imu.back());
    imu.back().t = keyframes.back().t;
  }
  return madeWindow(calibration, keyframes, imu);
}

CalibrationCheck check(const InitWindow& window) {
  const RobustBias bias = robustBiasOf(window);
  EXPECT_TRUE(bias.valid());
  return checkCalibration(window, bias.gyro_bias, bias.rotations);
}

double extrinsicErrorDeg(const CalibrationCheck& found) {
  return found.extrinsic_error.norm() / kRadPerDeg;
}

// In the direction of the error.
double extrinsicSigmaDeg(const CalibrationCheck& found) {
  const double angle = found.extrinsic_error.norm();
  const Eigen::Vector3d axis =
      angle > 0.0 ? Eigen::Vector3d(found.extrinsic_error / angle) : Eigen::Vector3d::UnitX();
  return std::sqrt(axis.dot(found.covariance.topLeftCorner<3, 3>() * axis)) / kRadPerDeg;
}

double tdSigma(const CalibrationCheck& found) { return std::sqrt(found.covariance(3, 3)); }

// What is left of an error that is taken for certain.
double certain(double error, double sigma) {
  constexpr double kConfidence = 2.5;
  return std::max(0.0, std::abs(error) - kConfidence * sigma);
}

double certainTd(const CalibrationCheck& found) {
  return certain(found.td_error_s, tdSigma(found));
}

double certainExtrinsicDeg(const CalibrationCheck& found) {
  return certain(extrinsicErrorDeg(found), extrinsicSigmaDeg(found));
}

TEST(CalibrationCheck, ATrueCalibrationHasNoError) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const CalibrationCheck found = check(*exactWindow(seed, 0.0).window);
    ASSERT_TRUE(found.valid);
    EXPECT_LT(extrinsicErrorDeg(found), 0.02) << "seed " << seed;
    EXPECT_LT(std::abs(found.td_error_s), 2e-4) << "seed " << seed;
  }
}

TEST(CalibrationCheck, ErrorsAreFoundWithTheirSignAndAxis) {
  // First order in the error: a twentieth of it is left at three degrees and 20 ms.
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ExactWindow exact = exactWindow(seed, 0.0);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d error = 3.0 * kRadPerDeg * Eigen::Vector3d::Unit(axis);
      const CalibrationCheck found = check(*miscalibrated(exact, error, 0.0));
      ASSERT_TRUE(found.valid);
      EXPECT_LT((found.extrinsic_error - error).norm(), 0.3 * kRadPerDeg)
          << "seed " << seed << " axis " << axis;
      EXPECT_LT(std::abs(found.td_error_s), 2e-3);
    }
    for (const double td : {-0.02, 0.02}) {
      const CalibrationCheck found = check(*miscalibrated(exact, Eigen::Vector3d::Zero(), td));
      ASSERT_TRUE(found.valid);
      EXPECT_NEAR(found.td_error_s, td, 2e-3) << "seed " << seed;
    }
  }
}

// Means over windows of the squared errors over their variances.
struct Consistency {
  double td = 0.0, extrinsic = 0.0;
  int certain = 0;  // windows that call a calibration wrong which is right
};
Consistency consistency(double pixel_noise, int windows) {
  Consistency mean;
  for (int seed = 1; seed <= windows; ++seed) {
    const CalibrationCheck found = check(*exactWindow(seed, pixel_noise).window);
    EXPECT_TRUE(found.valid);
    mean.td += std::pow(found.td_error_s / tdSigma(found), 2) / windows;
    mean.extrinsic += std::pow(extrinsicErrorDeg(found) / extrinsicSigmaDeg(found), 2) / windows;
    mean.certain += certainTd(found) > 0.0 || certainExtrinsicDeg(found) > 0.0;
  }
  return mean;
}

TEST(CalibrationCheck, WithNoiseTheStandardDeviationsHold) {
  constexpr int kWindows = 100;
  // Four times the usual noise, so that the floor of 1 mrad in a rotation, which the simulated
  // gyroscope does not need, is small beside it.
  const Consistency mean = consistency(2.4, kWindows);
  EXPECT_TRUE(isChiSquare(kWindows * mean.td, kWindows));
  // Along the error's own direction it is between one and three degrees of freedom, by the shape of
  // the covariance. A deviation wrong by a factor of 1.8 is out: 1.41 becomes 0.44 or 4.6.
  EXPECT_GT(mean.extrinsic, 1.0);
  EXPECT_LT(mean.extrinsic, 3.0);
}

TEST(CalibrationCheck, AtLittleNoiseTheFloorKeepsTheStandardDeviationsUp) {
  constexpr int kWindows = 60;
  const Consistency mean = consistency(0.6, kWindows);
  EXPECT_EQ(mean.certain, 0);
  EXPECT_LT(mean.td, 0.6);
  EXPECT_LT(mean.extrinsic, 1.0);
  // .. but not beyond twice what they were without it.
  EXPECT_GT(mean.td, 0.15);
  EXPECT_GT(mean.extrinsic, 0.25);
}

TEST(CalibrationCheck, WithoutRotationNothingIsSaid) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const CalibrationCheck found = check(*exactWindow(seed, 0.6, Motion::kConstantVelocity).window);
    ASSERT_TRUE(found.valid);
    EXPECT_GT(tdSigma(found), 0.05);
    EXPECT_GT(extrinsicSigmaDeg(found), 3.0);
    EXPECT_EQ(certainTd(found), 0.0);
    EXPECT_EQ(certainExtrinsicDeg(found), 0.0);
  }
}

TEST(CalibrationCheck, TooFewPairsAreNotValid) {
  const ExactWindow exact = exactWindow(1, 0.0);
  EXPECT_FALSE(checkCalibration(*exact.window, Eigen::Vector3d::Zero(), {}).valid);
}

}  // namespace
}  // namespace slim_init
