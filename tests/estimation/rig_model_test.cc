// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// How wide the prior of a calibration has to be, from what the data say about it.
#include "estimation/rig_model.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "geometry/so3.h"

namespace slim_init {
namespace {

constexpr double kRadPerDeg = M_PI / 180.0;
// Of two seconds of recorded motion.
constexpr double kMeasuredDeg = 0.35, kMeasuredTd = 0.7e-3;

RigError rigError(const Eigen::Vector3d& rotation_deg, double td) {
  RigError error;
  error.dR = expSO3(kRadPerDeg * rotation_deg);
  error.dtd = td;
  return error;
}

RigCovariance measured(double rotation_deg, double td) {
  RigCovariance covariance = RigCovariance::Zero();
  covariance.topLeftCorner<3, 3>().diagonal().setConstant(std::pow(kRadPerDeg * rotation_deg, 2));
  covariance(6, 6) = td * td;
  return covariance;
}

// The estimate under `sigmas` of an error that the data alone see at `seen` with `covariance`.
struct Drawn {
  RigError error;
  RigCovariance covariance = RigCovariance::Zero();
};

Drawn drawn(const CalibrationSigmas& sigmas, const RigError& seen, const RigCovariance& data) {
  Drawn out;
  const double rotation = std::pow(kRadPerDeg * sigmas.rotation_deg, 2);
  const Eigen::Matrix3d of_data = data.topLeftCorner<3, 3>();
  const Eigen::Matrix3d gain =
      rotation *
      (rotation * Eigen::Matrix3d::Identity() + of_data).ldlt().solve(Eigen::Matrix3d::Identity());
  out.error.dR = expSO3(gain * logSO3(seen.dR));
  out.covariance.topLeftCorner<3, 3>() = gain * of_data;
  const double td = sigmas.td_s * sigmas.td_s, share = td / (td + data(6, 6));
  out.error.dtd = share * seen.dtd;
  out.covariance(6, 6) = share * data(6, 6);
  out.covariance.block<3, 3>(3, 3).diagonal().setConstant(std::pow(sigmas.translation_m, 2));
  return out;
}

TEST(WidenedRig, AnErrorThatThePriorExplainsChangesNothing) {
  const CalibrationSigmas sigmas;
  const RigError error = rigError(0.25 * Eigen::Vector3d::Ones(), 1e-3);
  const RigCovariance data = measured(kMeasuredDeg, kMeasuredTd);
  EXPECT_EQ(widenedByMeasurement(sigmas, error, data), sigmas);
  const Drawn estimate = drawn(sigmas, error, data);
  EXPECT_EQ(widenedByEstimate(sigmas, estimate.error, estimate.covariance), sigmas);
}

TEST(WidenedRig, WhatWasNotMeasuredChangesNothing) {
  const CalibrationSigmas sigmas;
  EXPECT_EQ(widenedByMeasurement(sigmas, rigError({5.0, 0.0, 0.0}, 0.03), RigCovariance::Zero()),
            sigmas);
  // Nor what is said to be exact, or unknown.
  CalibrationSigmas exact;
  exact.rotation_deg = exact.td_s = exact.translation_m = 0.0;
  EXPECT_EQ(widenedByMeasurement(exact, rigError({5.0, 0.0, 0.0}, 0.03),
                                 measured(kMeasuredDeg, kMeasuredTd)),
            exact);
  CalibrationSigmas unknown;
  unknown.rotation_deg = CalibrationSigmas::kUnknownRotationDeg;
  EXPECT_EQ(widenedByMeasurement(unknown, rigError({50.0, 0.0, 0.0}, 0.0),
                                 measured(kMeasuredDeg, kMeasuredTd)),
            unknown);
}

// Both tests see the same data, with and without the prior.
TEST(WidenedRig, AContradictedPriorGetsTheWidthOfTheError) {
  const CalibrationSigmas sigmas;
  const RigCovariance data = measured(kMeasuredDeg, kMeasuredTd);
  for (const double deg : {1.5, 3.0, 6.0}) {
    const RigError error = rigError(deg * Eigen::Vector3d(0.6, 0.0, 0.8), 0.0);
    const CalibrationSigmas wide = widenedByMeasurement(sigmas, error, data);
    EXPECT_GT(wide.rotation_deg, deg / std::sqrt(3.0)) << deg;
    EXPECT_LT(wide.rotation_deg, 2.0 * deg) << deg;
    const Drawn estimate = drawn(sigmas, error, data);
    const CalibrationSigmas again = widenedByEstimate(sigmas, estimate.error, estimate.covariance);
    EXPECT_GT(again.rotation_deg, deg / std::sqrt(3.0)) << deg;
    EXPECT_LT(again.rotation_deg, 2.0 * deg) << deg;
  }
  for (const double td : {0.005, 0.02}) {
    const CalibrationSigmas wide =
        widenedByMeasurement(sigmas, rigError(Eigen::Vector3d::Zero(), td), data);
    EXPECT_GE(wide.td_s, td);
    EXPECT_LT(wide.td_s, 4.0 * td);
  }
}

// Care is one property of a rig: stamps that are off by eight of their standard deviations say
// that the rotation was not measured to a quarter of a degree either. Not where the file says so.
TEST(WidenedRig, OnePartSpeaksForTheOthers) {
  CalibrationSigmas sigmas;
  const RigCovariance data = measured(kMeasuredDeg, kMeasuredTd);
  const RigError late = rigError(Eigen::Vector3d::Zero(), 0.008);
  const CalibrationSigmas wide = widenedByMeasurement(sigmas, late, data);
  EXPECT_NEAR(wide.rotation_deg / sigmas.rotation_deg, wide.td_s / sigmas.td_s, 1e-9);
  EXPECT_GT(wide.translation_m, sigmas.translation_m);
  EXPECT_LE(wide.translation_m, 0.01) << "a wrong lever arm is less of a mistake";
  EXPECT_EQ(wide.readout_s, sigmas.readout_s);
  // And no part gets wider than what a rig without any calibration has.
  const CalibrationSigmas turned =
      widenedByMeasurement(sigmas, rigError({10.0, 5.0, -8.0}, 0.0), data);
  EXPECT_LE(turned.rotation_deg, 10.0);
  EXPECT_LE(turned.td_s, 0.05);

  sigmas.td_s = 0.03;  // estimate_td: 1
  EXPECT_EQ(widenedByMeasurement(sigmas, late, data), sigmas);
}

// Along an axis that the window hardly knows an estimate stays at its prior whatever the truth is;
// but it should not move there at all.
TEST(WidenedRig, AnEstimateThatMovesAgainstItsPriorIsSeen) {
  const CalibrationSigmas sigmas;
  Drawn estimate;
  const double kept = 0.95;  // of the variance
  estimate.covariance.topLeftCorner<3, 3>().diagonal().setConstant(
      kept * std::pow(kRadPerDeg * sigmas.rotation_deg, 2));
  const double expected_deg = std::sqrt(1.0 - kept) * sigmas.rotation_deg;
  estimate.error = rigError({expected_deg, 0.0, 0.0}, 0.0);
  EXPECT_EQ(widenedByEstimate(sigmas, estimate.error, estimate.covariance), sigmas);
  estimate.error = rigError({6.0 * expected_deg, 0.0, 0.0}, 0.0);
  EXPECT_GT(widenedByEstimate(sigmas, estimate.error, estimate.covariance).rotation_deg,
            4.0 * sigmas.rotation_deg);
}

// A right rig is rarely taken for a wrong one, and a wrong one always seen.
TEST(WidenedRig, RightAndWrongRigs) {
  const CalibrationSigmas sigmas;
  const RigCovariance data = measured(kMeasuredDeg, kMeasuredTd);
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;
  const auto draw = [&](double rotation_deg, double td) {
    const auto noisy = [&](double sigma, double noise) {
      return std::hypot(sigma, noise) * normal(rng);
    };
    Eigen::Vector3d rotation;
    for (int i = 0; i < 3; ++i) rotation[i] = noisy(rotation_deg, kMeasuredDeg);
    const Drawn estimate = drawn(sigmas, rigError(rotation, noisy(td, kMeasuredTd)), data);
    return widenedByEstimate(sigmas, estimate.error, estimate.covariance);
  };
  constexpr int kRigs = 2000;
  int right = 0, wrong = 0;
  double squares = 0.0;
  for (int i = 0; i < kRigs; ++i) {
    right += draw(sigmas.rotation_deg, sigmas.td_s) == sigmas ? 1 : 0;
    const CalibrationSigmas wide = draw(4.0, 0.02);
    wrong += wide.rotation_deg > 4.0 * sigmas.rotation_deg ? 1 : 0;
    squares += std::pow(std::log(wide.rotation_deg / 4.0), 2);
  }
  EXPECT_GT(right, 0.8 * kRigs);
  EXPECT_GT(wrong, 0.99 * kRigs);
  EXPECT_LT(std::sqrt(squares / kRigs), std::log(2.5)) << "the width is that of the errors";
}

}  // namespace
}  // namespace slim_init
