// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What counts as rest and what does not, on both sides of every bound, and the prior of a rest.
#include "verdict/rest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "estimation/state_factor.h"
#include "geometry/so3.h"
#include "support/exact_window.h"
#include "support/gaussian.h"

namespace slim_init {
namespace {

constexpr double kG = 9.81007;
constexpr int kImages = 21;  // at 20 Hz: 1 s

ExactWindow standing(unsigned seed, int points = 100, int images = kImages) {
  ExactWindowOptions options = drawnFromTheModel(seed, 0.05);
  options.motion = Motion::kHover;
  options.keyframes = images;
  options.interval_s = 0.05;
  options.points = points;
  return makeExactWindow(options);
}

using ChangeSample = std::function<void(ImuSample*)>;
using ChangeBearing = std::function<void(double t, Eigen::Vector3d*)>;

// The window with its samples or its bearings changed; null leaves them.
RestMeasures measured(ExactWindow exact, const ChangeSample& change_sample,
                      const ChangeBearing& change_bearing = nullptr) {
  if (change_sample) {
    for (ImuSample& sample : exact.imu) change_sample(&sample);
  }
  if (change_bearing) {
    for (FrameObservation& frame : exact.keyframes) {
      for (PointObservation& point : frame.points) change_bearing(frame.t, &point.bearing);
    }
  }
  return measureRest(*windowOf(exact));
}

int rests(int windows, const ChangeSample& change_sample,
          const ChangeBearing& change_bearing = nullptr, int images = kImages) {
  int count = 0;
  for (int seed = 1; seed <= windows; ++seed) {
    const RestMeasures rest = measured(standing(seed, 100, images), change_sample, change_bearing);
    count += rest.isRest(kG, InertialOptions()) ? 1 : 0;
  }
  return count;
}

TEST(Rest, AStandingBodyIsAtRestWithManyPointsAndWithFew) {
  EXPECT_GE(rests(100, nullptr), 99);
  int with_few = 0, with_none = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    with_few += measured(standing(seed, 60), nullptr).isRest(kG, InertialOptions()) ? 1 : 0;
    with_none += measured(standing(seed, 15), nullptr).isRest(kG, InertialOptions()) ? 1 : 0;
  }
  EXPECT_GE(with_few, 95);
  // Fewer tracks than kFewestForSpread say nothing.
  EXPECT_EQ(with_none, 0);
}

TEST(Rest, MeasuresAreAboutOneAtRest) {
  double tracks = 0.0, rate = 0.0, force = 0.0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const RestMeasures rest = measured(standing(seed), nullptr);
    tracks += rest.tracks / 100;
    rate += rest.rate * rest.rate / 100;
    force += rest.force * rest.force / 100;
  }
  EXPECT_NEAR(tracks, 1.0, 0.1);
  EXPECT_NEAR(rate, 1.0, 0.4);  // the noise of a window is measured in that window
  EXPECT_NEAR(force, 1.0, 0.4);
}

TEST(Rest, AnIdlingEngineIsAtRest) {
  // 0.6 m/s^2 and 0.02 rad/s at 31 Hz: EuRoC's rotors on the ground have a density seven times that
  // of the data sheet.
  const ChangeSample shake = [](ImuSample* sample) {
    const double phase = 2.0 * M_PI * 31.0 * sample->t;
    sample->accel += 0.6 * std::sin(phase) * Eigen::Vector3d(1.0, 0.3, 0.5);
    sample->gyro += 0.02 * std::cos(phase) * Eigen::Vector3d(0.4, 1.0, 0.2);
  };
  EXPECT_GE(rests(100, shake), 99);
  EXPECT_EQ(rests(100, shake, nullptr, 2 * kImages), 100);
}

TEST(Rest, AMotionIsNoneAndNeitherIsItsBeginning) {
  // A turntable whose scene turns with it, and half a g more, as in a lift seen from inside.
  EXPECT_EQ(rests(100, [](ImuSample* s) { s->gyro.z() += 0.5; }), 0);
  EXPECT_EQ(rests(100, [](ImuSample* s) { s->accel *= 1.5; }), 0);
  // The last tenth of the window accelerates, or turns; the images hardly show it.
  EXPECT_EQ(rests(100, [](ImuSample* s) { s->accel.x() += s->t > 0.9 ? 0.3 : 0.0; }), 0);
  EXPECT_EQ(rests(100, [](ImuSample* s) { s->gyro.y() += s->t > 0.9 ? 0.015 : 0.0; }), 0);
  // A tenth of that is noise.
  EXPECT_GE(rests(100, [](ImuSample* s) { s->accel.x() += s->t > 0.9 ? 0.005 : 0.0; }), 95);
}

TEST(Rest, TracksThatMoveUnderAStillImuAreNone) {
  // 2 px and 0.2 px in the window, all of them to one side: constant velocity. The IMU cannot see
  // it.
  const auto slide = [](double pixels) {
    return [pixels](double t, Eigen::Vector3d* bearing) {
      *bearing = (*bearing + Eigen::Vector3d(pixels / 458.0 * t, 0.0, 0.0)).normalized();
    };
  };
  EXPECT_EQ(rests(100, nullptr, slide(2.0)), 0);
  EXPECT_GE(rests(100, nullptr, slide(0.2)), 90);
}

TEST(Rest, WhatTheTracksMoveWidensTheGyroscopeBias) {
  // 1 px/s to one side in two seconds: 2.2 mrad/s, of which the noise hides hardly anything.
  const auto sway = [](double t, Eigen::Vector3d* bearing) {
    *bearing = (*bearing + Eigen::Vector3d(t / 458.0, 0.0, 0.0)).normalized();
  };
  const auto sigmaOf = [](const RestMeasures& rest) {
    return std::sqrt(priorAtRest(rest, 0.0, kG, ImuBiases(), InertialOptions()).covariance(9, 9));
  };
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const RestMeasures still = measured(standing(seed, 100, 2 * kImages), nullptr);
    const RestMeasures moved = measured(standing(seed, 100, 2 * kImages), nullptr, sway);
    EXPECT_LT(still.turn_rate, 0.5e-3);
    EXPECT_NEAR(moved.turn_rate, 1.0 / 458.0, 0.3 / 458.0);  // bearings off the axis move less
    EXPECT_GE(sigmaOf(moved), moved.turn_rate);
    EXPECT_LT(sigmaOf(still), 0.5 * sigmaOf(moved));
  }
}

TEST(Rest, WithoutSamplesOrTracksNothingIsMeasured) {
  EXPECT_FALSE(RestMeasures().isRest(kG, InertialOptions()));
  ExactWindow exact = standing(1);
  for (FrameObservation& frame : exact.keyframes) frame.points.clear();
  EXPECT_FALSE(measured(exact, nullptr).isRest(kG, InertialOptions()));
}

// The prior of 2,000 draws of bias and noise: its errors are what its covariance says, tilt and
// bias together.
TEST(RestPrior, ErrorsAreWhatTheCovarianceSays) {
  Gaussian draw(1);
  const InertialOptions inertial;
  RestMeasures rest;
  rest.rate_sigma = 1e-3;
  rest.force_sigma = 0.3;  // so large that kRestForceSigma does not matter
  double squared = 0.0;
  constexpr int kDraws = 2000;
  for (int k = 0; k < kDraws; ++k) {
    const Eigen::Matrix3d R = expSO3(2.0 * draw.vector());
    const Eigen::Vector3d up = R.transpose().col(2),
                          bias = inertial.accel_bias_prior * draw.vector();
    rest.mean_force = kG * up + bias + rest.force_sigma * draw.vector();
    rest.mean_rate = rest.rate_sigma * draw.vector();
    StatePrior prior = priorAtRest(rest, 3.0, kG, ImuBiases(), inertial);
    EXPECT_EQ(prior.validate(), "");
    EXPECT_EQ(prior.state.t, 3.0);
    EXPECT_TRUE(prior.at_rest);
    const StateFactor factor = stateFactor(prior);
    Eigen::Matrix<double, 8, 1> error;
    error << tangentBasis(factor.down_b).transpose() * -up, -factor.gyro_bias,
        bias - factor.accel_bias;
    const Eigen::Matrix<double, 8, 8> P = factor.covariance.bottomRightCorner<8, 8>();
    squared += error.dot(P.ldlt().solve(error)) / (8.0 * kDraws);
  }
  EXPECT_NEAR(squared, 1.0, 0.1);
}

TEST(RestPrior, KnownBiasesLevelTheTilt) {
  const InertialOptions inertial;
  RestMeasures rest;
  rest.rate_sigma = 1e-3;
  rest.force_sigma = 1e-3;
  ImuBiases known;
  known.accel = Eigen::Vector3d(0.3, 0.0, 0.0);
  known.accel_sigma = 0.02;
  rest.mean_force = Eigen::Vector3d(0.3, 0.0, kG + 0.1);
  const StatePrior prior = priorAtRest(rest, 0.0, kG, known, inertial);
  EXPECT_LT(logSO3(prior.state.R_w_b).norm(), 1e-9);
  EXPECT_LT((prior.state.accel_bias - Eigen::Vector3d(0.3, 0.0, 0.1)).norm(), 1e-9);
  const StatePrior without = priorAtRest(rest, 0.0, kG, ImuBiases(), inertial);
  EXPECT_GT(logSO3(without.state.R_w_b).norm(), 0.03);
  EXPECT_GT(without.covariance(0, 0), 4.0 * prior.covariance(0, 0));
  // Zero velocity, and a pose that defines the world.
  EXPECT_EQ(prior.state.v_w_b.norm(), 0.0);
  EXPECT_EQ(prior.covariance.block(3, 3, 3, 3).norm(), 0.0);
}

}  // namespace
}  // namespace slim_init
