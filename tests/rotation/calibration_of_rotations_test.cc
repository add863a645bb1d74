// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/so3.h"
#include "support/exact_window.h"
#include "support/robust_bias.h"

namespace slim_init {
namespace {

constexpr double kRadPerDeg = M_PI / 180.0;

ExactWindow noiseFree(unsigned seed) {
  ExactWindowOptions options;
  options.seed = seed;
  return makeExactWindow(options);
}

RobustBias found(const InitWindow& window) {
  const RobustBias bias = robustBiasOf(window);
  EXPECT_TRUE(bias.valid());
  return bias;
}

double extrinsicErrorDeg(const RobustBias& found) {
  return logSO3(found.rig.dR).norm() / kRadPerDeg;
}

// Of a right calibration none; of others with hardly a prior, which would pull towards them.
TEST(CalibrationOfRotations, ErrorsAreFoundWithTheirSignAndAxis) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ExactWindow exact = noiseFree(seed);
    const RobustBias none = found(*exact.window);
    EXPECT_LT(extrinsicErrorDeg(none), 0.02) << "seed " << seed;
    EXPECT_LT(std::abs(none.rig.dtd), 2e-4) << "seed " << seed;
    CalibrationSigmas wide;
    wide.rotation_deg = CalibrationSigmas::kUnknownRotationDeg;
    wide.td_s = 0.5;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d error = 3.0 * kRadPerDeg * Eigen::Vector3d::Unit(axis);
      const RobustBias bias = found(*miscalibrated(exact, error, 0.0, wide));
      EXPECT_LT((logSO3(bias.rig.dR) - error).norm(), 0.3 * kRadPerDeg)
          << "seed " << seed << " axis " << axis;
      EXPECT_LT(std::abs(bias.rig.dtd), 2e-3);
    }
    for (const double td : {-0.02, 0.02}) {
      const RobustBias bias = found(*miscalibrated(exact, Eigen::Vector3d::Zero(), td, wide));
      EXPECT_NEAR(bias.rig.dtd, td, 2e-3) << "seed " << seed;
    }
  }
}

TEST(CalibrationOfRotations, LargeErrorsAreFoundUnderNoise) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const ExactWindow exact = makeExactWindow(drawnFromTheModel(seed, 0.05));
    const Eigen::Vector3d error = 10.0 * kRadPerDeg * Eigen::Vector3d(0.6, -0.64, 0.48);
    const RobustBias bias = found(*miscalibrated(exact, error, 0.05, CalibrationSigmas()));
    EXPECT_LT((logSO3(bias.rig.dR) - error).norm(), 1.5 * kRadPerDeg) << "seed " << seed;
    EXPECT_NEAR(bias.rig.dtd, 0.05, 0.005) << "seed " << seed;
  }
}

// Without rotation nothing is said of the calibration. At a constant rate td is no different from
// a bias, and with one axis the extrinsic is free about it: there the priors hold, and the bias is
// as good as with a calibration that is exact.
TEST(CalibrationOfRotations, WhatTheMotionDoesNotShowStaysAtItsPrior) {
  const auto constant = [](const Eigen::Vector3d& rate) { return [rate](double) { return rate; }; };
  const auto swing = [](double t) -> Eigen::Vector3d {
    return 0.6 * std::cos(2.0 * t) * Eigen::Vector3d::UnitZ();
  };
  for (int motion = 0; motion < 4; ++motion) {
    double free2 = 0.0, held2 = 0.0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      ExactWindowOptions options = drawnFromTheModel(seed, 0.05);
      if (motion == 0) options.motion = Motion::kConstantVelocity;
      if (motion == 1) options.angular_rate = constant({0.2, -0.3, 0.4});
      if (motion == 2) options.angular_rate = constant({0.0, 0.0, 0.8});
      if (motion == 3) options.angular_rate = swing;
      ExactWindow exact = makeExactWindow(options);
      const RobustBias bias = found(*exact.window);
      const CalibrationSigmas& sigmas = exact.calibration.sigmas;
      EXPECT_LT(extrinsicErrorDeg(bias), sigmas.rotation_deg) << motion << " seed " << seed;
      EXPECT_LT(std::abs(bias.rig.dtd), sigmas.td_s) << motion << " seed " << seed;
      free2 += (bias.gyro_bias - options.gyro_bias).squaredNorm();
      exact.calibration.sigmas = kExactCalibration;
      held2 += (found(*windowOf(exact)).gyro_bias - options.gyro_bias).squaredNorm();
    }
    EXPECT_LT(free2, 1.5 * 1.5 * held2) << motion;
  }
}

}  // namespace
}  // namespace slim_init
