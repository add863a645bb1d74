// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Measured velocities: with them the scale is known at constant velocity, a slipping wheel is found
// where the motion shows the scale, and what cannot be used is named and counted.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "estimation/speed_factor.h"
#include "slim_init/initializer.h"
#include "support/exact_window.h"
#include "support/gaussian.h"
#include "support/text_parts.h"

namespace slim_init {
namespace {

enum class Kind { kForward, kNonHolonomic, kVelocity };

// How the wheel measures.
struct Wheel {
  Kind kind = Kind::kForward;
  Eigen::Vector3d t_b_s = Eigen::Vector3d(-0.5, 0.2, -0.3);  // [m]
  double noise = 0.0;                                        // fraction of the speed
  double scale = 1.0;                                        // of all measurements
  int slipping = 0;   // so many keyframes of the window, the first ones...
  double slip = 1.0;  // ...by this factor
  int left_out = 0;   // keyframes without a measurement, the last ones
  double lag = 0.0;   // a measurement so long before and one so long after each keyframe [s]
  unsigned seed = 1;
};

// Of the whole velocity, with noise of 5 %.
Wheel noisyVelocity(unsigned seed) {
  Wheel wheel;
  wheel.kind = Kind::kVelocity;
  wheel.noise = 0.05;
  wheel.seed = seed;
  return wheel;
}

// x along the velocity of the first keyframe, so that nothing moves sideways at constant velocity.
SpeedSensor sensorOf(const Wheel& wheel, const ExactWindow& exact) {
  const NavState& first = exact.truth.front();
  SpeedSensor sensor;
  sensor.calibrated = true;
  sensor.R_b_s = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(),
                                                    first.R_w_b.transpose() * first.v_w_b)
                     .matrix();
  sensor.t_b_s = wheel.t_b_s;
  if (wheel.kind == Kind::kNonHolonomic) sensor.lateral_sigma = 0.05;
  return sensor;
}

// Rate of the body at time t from the samples, without their bias.
Eigen::Vector3d rateAt(const ExactWindow& exact, double t) {
  const auto after = std::find_if(exact.imu.begin(), exact.imu.end(),
                                  [t](const ImuSample& sample) { return sample.t >= t; });
  const auto before = std::prev(after);
  const double u = (t - before->t) / (after->t - before->t);
  return (1.0 - u) * before->gyro + u * after->gyro - exact.truth.front().gyro_bias;
}

std::vector<SpeedSample> measure(const Wheel& wheel, const SpeedSensor& sensor,
                                 const ExactWindow& exact) {
  Gaussian gaussian(wheel.seed);
  std::vector<SpeedSample> samples;
  const int n = static_cast<int>(exact.truth.size());
  const int first = wheel.left_out < 0 ? -wheel.left_out : 0;
  for (int k = first; k < n - std::max(wheel.left_out, 0); ++k) {
    const NavState& state = exact.truth[k];
    const Eigen::Vector3d v_b =
        state.R_w_b.transpose() * state.v_w_b + rateAt(exact, state.t).cross(sensor.t_b_s);
    const double factor = wheel.scale * (k < wheel.slipping ? wheel.slip : 1.0);
    Eigen::Vector3d v_s = factor * sensor.R_b_s.transpose() * v_b;
    const double sigma = std::max(0.01, wheel.noise * v_s.norm());
    if (wheel.noise > 0.0) v_s.x() += sigma * gaussian();
    SpeedSample sample = SpeedSample::forward(state.t - wheel.lag, v_s.x(), sigma);
    if (wheel.kind == Kind::kVelocity) {
      sample.velocity = v_s;
      sample.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
      sample.forward_only = false;
    }
    samples.push_back(sample);
    if (wheel.lag == 0.0) continue;
    sample.t = state.t + wheel.lag;
    samples.push_back(sample);
  }
  return samples;
}

InitResult solve(const ExactWindow& exact, const Wheel* wheel,
                 const CalibrationSigmas& sigmas = kExactCalibration) {
  Calibration calibration = exact.calibration;
  calibration.sigmas = sigmas;
  std::vector<SpeedSample> speeds;
  if (wheel != nullptr) {
    calibration.speed_sensor = sensorOf(*wheel, exact);
    speeds = measure(*wheel, calibration.speed_sensor, exact);
  }
  const auto window = madeWindow(calibration, exact.keyframes, exact.imu, speeds);
  return makeSlimSolver(InitializerOptions())->solve(*window);
}

ExactWindow constantVelocity() {
  ExactWindowOptions options;
  options.motion = Motion::kConstantVelocity;
  return makeExactWindow(options);
}

TEST(Speed, GivesTheScaleAtConstantVelocity) {
  const ExactWindow exact = constantVelocity();
  EXPECT_EQ(solve(exact, nullptr).status, InitStatus::kTooLittleExcitation);
  for (const Kind kind : {Kind::kForward, Kind::kNonHolonomic, Kind::kVelocity}) {
    for (const Eigen::Vector3d& t_b_s :
         {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(-0.5, 0.2, -0.3)}) {
      Wheel wheel;
      wheel.kind = kind;
      wheel.t_b_s = t_b_s;
      const InitResult result = solve(exact, &wheel);
      ASSERT_TRUE(result.success()) << result.message;
      EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), 1e-3);
      EXPECT_EQ(result.speeds.keyframes, 10);
      EXPECT_EQ(result.speeds.contradicted, 0);
      // No more certain than the wheel, and the reader is told whose scale it is.
      EXPECT_GT(result.scale_sigma, SpeedSensor().scale_sigma);
      EXPECT_TRUE(anyContains(result.warnings, "the scale is that of the measured velocities"));
      expectParts(result.message, "an error of the sensor would not show");
    }
  }
}

TEST(Speed, IsInterpolatedToTheKeyframes) {
  const ExactWindow exact = constantVelocity();
  for (const double lag : {0.02, 0.09}) {
    Wheel wheel;
    wheel.lag = lag;
    const InitResult result = solve(exact, &wheel);
    EXPECT_TRUE(result.success()) << result.message;
    EXPECT_EQ(result.speeds.missing, 0);
    EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), 1e-3);
  }
  // More than kMaxSpeedGap apart: none of them is used, and the window is what it is without.
  Wheel wheel;
  wheel.lag = 0.11;
  const InitResult result = solve(exact, &wheel);
  EXPECT_FALSE(result.success());
  EXPECT_EQ(result.status, InitStatus::kTooLittleExcitation);
}

TEST(Speed, NeedsSomeKeyframesAndSaysHowManyAreWithout) {
  const ExactWindow exact = constantVelocity();
  for (const int left_out : {0, 1, 3, 7, 8}) {
    Wheel wheel;
    wheel.left_out = left_out;
    const InitResult result = solve(exact, &wheel);
    EXPECT_EQ(result.success(), left_out < 8) << left_out << ": " << result.message;
    if (left_out == 8) continue;
    EXPECT_EQ(result.speeds.missing, left_out);
    EXPECT_EQ(anyContains(result.warnings,
                          "no measured velocity at " + std::to_string(left_out) + " of 10"),
              left_out > 1)
        << "the newest keyframe is ahead of the newest velocity";
  }
  Wheel wheel;
  wheel.left_out = -1;
  EXPECT_TRUE(anyContains(solve(exact, &wheel).warnings, "no measured velocity at 1 of 10"));
}

// Noise of 5 % at ten keyframes and the error that all have in common: 2.6 %, three of them.
TEST(Speed, NoiseLeavesTheScaleWithinThreeSigma) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ExactWindow exact = noisyWindow(Motion::kConstantVelocity, seed);
    Wheel wheel;
    wheel.noise = 0.05;
    wheel.seed = seed;
    const InitResult result = solve(exact, &wheel);
    ASSERT_TRUE(result.success()) << result.message;
    EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), 0.08) << seed;
  }
}

TEST(Speed, SomeThatSlipAreNamedAndDoNoHarm) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ExactWindow exact = noisyWindow(Motion::kExcited, seed);
    Wheel wheel = noisyVelocity(seed);
    wheel.slipping = 4;
    wheel.slip = 1.5;
    const InitResult result = solve(exact, &wheel);
    ASSERT_TRUE(result.success()) << result.message;
    EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), 0.06) << seed;
    EXPECT_GE(result.speeds.contradicted, 3);
    EXPECT_TRUE(anyContains(result.warnings, "measured velocities contradict")) << seed;
  }
}

// All the time, in a motion that shows the scale: solved as if there were no wheel, but for the
// ratios of its speeds.
TEST(Speed, AWheelWithAnotherScaleIsOverruled) {
  for (const double scale : {1.2, 3.0, 0.5}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const ExactWindow exact = noisyWindow(Motion::kExcited, seed);
      Wheel wheel = noisyVelocity(seed);
      wheel.scale = scale;
      const InitResult with = solve(exact, &wheel), without = solve(exact, nullptr);
      ASSERT_TRUE(with.success()) << with.message;
      EXPECT_NEAR(with.scale / without.scale, 1.0, 0.25 * without.scale_sigma) << scale;
      EXPECT_GT(with.scale_sigma, 0.9 * without.scale_sigma) << scale;
      EXPECT_EQ(with.speeds.contradicted, 10);
      EXPECT_TRUE(anyContains(with.warnings, "measured velocities contradict")) << scale;
    }
  }
}

// Ten that fit but for an error that all have in common: within its standard deviation it is held
// near zero, far beyond it is free.
TEST(Speed, TheCommonErrorIsFreeWhereTheMotionContradictsIt) {
  constexpr double kScaleSigma = 0.02, kNoise = 0.05;
  for (const auto& [error, found, contradicted] :
       {std::tuple(0.0, 0.0, 0), {0.02, 0.0125, 0}, {0.2, 0.2, 10}, {5.0, 5.0, 10}}) {
    SpeedResidual residual;
    residual.J.setZero();
    residual.by_scale = Eigen::Vector3d(1.0 / kNoise, 0.0, 0.0);
    residual.r = -error * residual.by_scale;
    const SpeedFit fit = fitSpeeds(std::vector<SpeedResidual>(10, residual), kScaleSigma);
    EXPECT_NEAR(fit.use.scale_error, found, 0.1 * kScaleSigma) << error;
    EXPECT_EQ(fit.use.contradicted, contradicted) << error;
    // Each of the eleven costs at most the square of the cutoff.
    EXPECT_LE(fit.cost, 11 * 9.0);
  }
}

TEST(Speed, StandsBesideAnEstimatedCalibration) {
  ExactWindowOptions options = drawnWithCalibration(3, 0.05);
  options.motion = Motion::kConstantVelocity;
  const ExactWindow exact = makeExactWindow(options);
  Wheel wheel;
  wheel.noise = 0.02;
  wheel.lag = 0.02;
  const InitResult result = solve(exact, &wheel, exact.calibration.sigmas);
  ASSERT_TRUE(result.success()) << result.message;
  EXPECT_TRUE(result.calibration.has_value());
  EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), 0.08);
}

class SpeedStream : public ::testing::Test {
 protected:
  SpeedStream() {
    calibration_ = eurocCalibration();
    calibration_.speed_sensor.calibrated = true;
    make();
  }
  void make() { initializer_ = makeInitializer(calibration_, InitializerOptions(), &error_); }

  Calibration calibration_;
  std::unique_ptr<IInitializer> initializer_;
  std::string error_;
};

TEST_F(SpeedStream, WhatCannotBeUsedIsNamedAndCounted) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  ImuSample sample;
  for (sample.t = 9.0; sample.t < 10.0; sample.t += 0.005) initializer_->addImu(sample);
  SpeedSample skew = SpeedSample::forward(10.1, 1.0, 0.1);
  skew.forward_only = false;
  skew.covariance = Eigen::Vector3d(0.01, 0.01, -0.01).asDiagonal();
  const std::pair<SpeedSample, AddStatus> cases[] = {
      {SpeedSample::forward(10.0, 1.0, 0.1), AddStatus::kAdded},
      {SpeedSample::forward(10.0, 1.0, 0.1), AddStatus::kOutOfOrder},
      {SpeedSample::forward(9.9, 1.0, 0.1), AddStatus::kOutOfOrder},
      {SpeedSample::forward(kNan, 1.0, 0.1), AddStatus::kNotFinite},
      {SpeedSample::forward(10.1, kInfinity, 0.1), AddStatus::kNotFinite},
      {SpeedSample::forward(10.1, 1.0, kNan), AddStatus::kNotFinite},
      {SpeedSample::forward(10.1, 1.0, 0.0), AddStatus::kNoCovariance},
      {SpeedSample::forward(10.1, 1.0, -0.1), AddStatus::kNoCovariance},
      {skew, AddStatus::kNoCovariance},
      {SpeedSample::forward(10.1, -101.0, 0.1), AddStatus::kGlitch},
      {SpeedSample::forward(12.0, 1.0, 0.1), AddStatus::kStray},
      {SpeedSample::forward(10.1, -1.0, 0.1), AddStatus::kAdded},
  };
  for (const auto& [speed, status] : cases) {
    const std::int64_t before = initializer_->info().counts.speeds[status];
    EXPECT_EQ(initializer_->addSpeed(speed), status);
    EXPECT_EQ(initializer_->info().counts.speeds[status], before + 1);
  }
}

TEST_F(SpeedStream, ASensorWithoutExtrinsicsIsRefused) {
  calibration_.speed_sensor.calibrated = false;
  make();
  const SpeedSample sample = SpeedSample::forward(10.0, 1.0, 0.1);
  EXPECT_EQ(initializer_->addSpeed(sample), AddStatus::kNotCalibrated);
  EXPECT_EQ(initializer_->info().counts.speeds[AddStatus::kNotCalibrated], 1);
  const ExactWindow exact = constantVelocity();
  EXPECT_EQ(InitWindow::create(exact.calibration, exact.keyframes, exact.imu, &error_, {sample}),
            nullptr);
  expectParts(error_, "sensor without extrinsics");
}

TEST_F(SpeedStream, AnImpossibleSensorIsNamed) {
  const std::pair<const char*, void (*)(SpeedSensor*)> cases[] = {
      {"speed_sensor.distance of R_b_s", [](SpeedSensor* s) { s->R_b_s *= 2.0; }},
      {"speed_sensor.norm of t_b_s", [](SpeedSensor* s) { s->t_b_s.x() = 30.0; }},
      {"speed_sensor.scale_sigma", [](SpeedSensor* s) { s->scale_sigma = 0.0; }},
      {"speed_sensor.lateral_sigma", [](SpeedSensor* s) { s->lateral_sigma = -1.0; }},
  };
  for (const auto& [name, spoil] : cases) {
    calibration_.speed_sensor = SpeedSensor();
    spoil(&calibration_.speed_sensor);
    make();
    EXPECT_EQ(initializer_, nullptr);
    expectParts(error_, name);
  }
}

}  // namespace
}  // namespace slim_init
