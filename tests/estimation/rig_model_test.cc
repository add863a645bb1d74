// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The priors of calibration and accelerometer bias: Gaussian near their mean, and with less of a
// say far from it.
#include <gtest/gtest.h>

#include <cmath>

#include "estimation/inertial_factor.h"
#include "geometry/so3.h"

namespace slim_init {
namespace {

constexpr double kRadPerDeg = M_PI / 180.0;
constexpr int kTranslation = 3, kTd = 6, kReadout = 7;  // rows

RigError rigError(const Eigen::Vector3d& rotation_deg, double td) {
  RigError error;
  error.dR = expSO3(kRadPerDeg * rotation_deg);
  error.dtd = td;
  return error;
}

RigError moved(const RigError& error, int row, double by) {
  RigVector step = RigVector::Zero();
  step[row] = by;
  RigError out;
  out.dR = error.dR * expSO3(step.head<3>());
  out.dt = error.dt + step.segment<3>(kTranslation);
  out.dtd = error.dtd + step[kTd];
  out.dreadout = error.dreadout + step[kReadout];
  return out;
}

TEST(RigPrior, GradientIsThatOfTheCost) {
  RigPrior prior;
  prior.mean = rigError({0.3, -0.2, 0.5}, 0.002);
  prior.mean.dt = {0.002, -0.001, 0.004};
  prior.sigmas.readout_s = 0.003;
  for (const double size : {0.3, 3.0, 30.0}) {
    RigError at = rigError(size * Eigen::Vector3d(0.2, -0.1, 0.3), size * 1e-3);
    at.dt = size * Eigen::Vector3d(0.004, 0.001, -0.002);
    at.dreadout = size * 0.002;
    const RigVector g = rigPriorTerm(prior, at).g;
    for (int row = 0; row < StateLayout::kRig; ++row) {
      constexpr double kStep = 1e-7;
      const double slope = (rigPriorTerm(prior, moved(at, row, kStep)).cost -
                            rigPriorTerm(prior, moved(at, row, -kStep)).cost) /
                           (2.0 * kStep);
      EXPECT_NEAR(2.0 * g[row], slope, 1e-5 * (1.0 + std::abs(slope))) << row << " at " << size;
    }
  }
}

TEST(RigPrior, NearItsMeanItIsTheGaussian) {
  const RigPrior prior;
  const CalibrationSigmas& sigmas = prior.sigmas;
  const RigPriorTerm at_mean = rigPriorTerm(prior, RigError());
  EXPECT_EQ(at_mean.cost, 0.0);
  EXPECT_EQ(at_mean.g.norm(), 0.0);
  EXPECT_DOUBLE_EQ(at_mean.H(0, 0), std::pow(sigmas.rotation_deg * kRadPerDeg, -2));
  EXPECT_DOUBLE_EQ(at_mean.H(kTranslation, kTranslation), std::pow(sigmas.translation_m, -2));
  EXPECT_DOUBLE_EQ(at_mean.H(kTd, kTd), std::pow(sigmas.td_s, -2));
  // One standard deviation costs one, but for the tail.
  const double cost = rigPriorTerm(prior, rigError({sigmas.rotation_deg, 0.0, 0.0}, 0.0)).cost;
  EXPECT_LT(cost, 1.0);
  EXPECT_GT(cost, 0.85);
}

// A calibration that is off by many of its standard deviations is not held back by them.
TEST(RigPrior, FarFromItsMeanThePullEnds) {
  const RigPrior prior;
  const auto pull = [&](double sigmas) {
    return rigPriorTerm(prior, rigError({sigmas * prior.sigmas.rotation_deg, 0.0, 0.0}, 0.0))
        .g.norm();
  };
  EXPECT_GT(pull(2.0), pull(1.0));
  EXPECT_LT(pull(20.0), 0.5 * pull(2.0));
  EXPECT_LT(pull(40.0), 0.6 * pull(20.0));
}

// Stamps that are off by twenty of their standard deviations say that the rotation was not measured
// with care either; they say nothing of lever arm and readout time.
TEST(RigPrior, RotationAndTdSpeakForEachOther) {
  RigPrior prior;
  prior.sigmas.readout_s = 0.003;
  const RigPriorTerm right = rigPriorTerm(prior, RigError());
  const RigPriorTerm late =
      rigPriorTerm(prior, rigError(Eigen::Vector3d::Zero(), 20.0 * prior.sigmas.td_s));
  EXPECT_LT(late.H(0, 0), 0.05 * right.H(0, 0));
  EXPECT_LT(late.H(kTd, kTd), 0.05 * right.H(kTd, kTd));
  EXPECT_EQ(late.H(kTranslation, kTranslation), right.H(kTranslation, kTranslation));
  EXPECT_EQ(late.H(kReadout, kReadout), right.H(kReadout, kReadout));
}

TEST(RigPrior, WhatIsExactIsHeldAndSpeaksForNothing) {
  RigPrior prior;
  prior.sigmas.td_s = 0.0;
  const RigPriorTerm late = rigPriorTerm(prior, rigError(Eigen::Vector3d::Zero(), 1e-3));
  EXPECT_GT(late.H(kTd, kTd), 1e11);
  EXPECT_EQ(late.H(0, 0), rigPriorTerm(prior, RigError()).H(0, 0));
}

TEST(AccelBiasPrior, IsWiderFarFromItsMeanUnlessTheBiasIsKnown) {
  const InertialOptions options;
  const auto term = [&](double bias, const ImuBiases& known = {}) {
    return accelBiasTerm(known, options, {0.0, bias, 0.0});
  };
  EXPECT_EQ(term(0.0).cost, 0.0);
  EXPECT_EQ(term(0.0).sigma, options.accel_bias_prior);
  for (const double bias : {0.02, 0.2, 0.8}) {
    constexpr double kStep = 1e-6;
    const double slope = (term(bias + kStep).cost - term(bias - kStep).cost) / (2.0 * kStep);
    EXPECT_NEAR(2.0 * bias / std::pow(term(bias).sigma, 2), slope, 1e-6 * slope) << bias;
  }
  EXPECT_GT(term(0.8).sigma, 3.0 * options.accel_bias_prior);
  ImuBiases known;
  known.accel_sigma = 0.02;
  EXPECT_EQ(term(0.8, known).sigma, 0.02);
  EXPECT_DOUBLE_EQ(term(0.8, known).cost, 1600.0);
}

}  // namespace
}  // namespace slim_init
