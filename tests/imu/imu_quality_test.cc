// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/imu_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace slim_init {
namespace {

using Eigen::Vector3d;

constexpr double kDuration = 2.45;           // a window of ten keyframes with its margins [s]
constexpr ImuNoise kSheet = {1.7e-4, 2e-3};  // gyroscope, accelerometer
// Standard deviation of a density measured once over such a window, relative: 2 % at 200 Hz, 3 % at
// 100 Hz from some 450 and 230 overlapping differences on three axes, and the least of several.
constexpr double kTolerance = 0.15;

struct Stream {
  double rate = 200.0;          // [Hz]
  double jitter = 0.0;          // standard deviation of the true sampling times [s]
  double drop = 0.0;            // share of the samples missing
  double duration = kDuration;  // [s]
};

using Motion = std::function<Vector3d(double)>;

// Samples of a motion, each at its own stamp, with white noise of given densities.
std::vector<ImuSample> record(const Stream& stream, const Motion& gyro, const Motion& accel,
                              const ImuNoise& noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const auto draw = [&] { return Vector3d{normal(random), normal(random), normal(random)}; };
  std::vector<ImuSample> out;
  const double bound = 0.4 / stream.rate;
  for (int k = 0; k < stream.duration * stream.rate; ++k) {
    const double shift = std::clamp(stream.jitter * normal(random), -bound, bound);
    const double t = k / stream.rate + shift;
    ImuSample sample;
    sample.t = t;
    sample.gyro = gyro(t) + noise.gyro_density * std::sqrt(stream.rate) * draw();
    sample.accel = accel(t) + noise.accel_density * std::sqrt(stream.rate) * draw();
    if (uniform(random) >= stream.drop) out.push_back(sample);
  }
  return out;
}

Vector3d quadratic(double t) {
  return Vector3d(1.0, -2.0, 9.8) + t * Vector3d(-3.0, 4.0, 0.5) + t * t * Vector3d(2.0, 1.0, -5.0);
}

// Motion of a hand: 1 Hz, several m/s^2 and rad/s.
Vector3d hand(double t) {
  return Vector3d(2.0 * std::sin(6.0 * t), 1.5 * std::cos(5.0 * t), 9.8 + std::sin(7.0 * t));
}

// Root of the mean square over several realisations, over the true density.
ImuNoise measuredOverTrue(const Stream& stream, const Motion& motion, const ImuNoise& noise) {
  constexpr int kRuns = 10;
  ImuNoise ratio = {0.0, 0.0};
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const ImuQuality quality = measureImuQuality(record(stream, motion, motion, noise, seed));
    EXPECT_TRUE(quality.measured());
    ratio.gyro_density += std::pow(quality.noise.gyro_density / noise.gyro_density, 2) / kRuns;
    ratio.accel_density += std::pow(quality.noise.accel_density / noise.accel_density, 2) / kRuns;
  }
  return {std::sqrt(ratio.gyro_density), std::sqrt(ratio.accel_density)};
}

void expectNoiseRecovered(const Stream& stream, const Motion& motion, const ImuNoise& noise) {
  const ImuNoise ratio = measuredOverTrue(stream, motion, noise);
  EXPECT_NEAR(ratio.gyro_density, 1.0, kTolerance);
  EXPECT_NEAR(ratio.accel_density, 1.0, kTolerance);
}

InertialOptions measuredNoise() {
  InertialOptions options;
  options.accel_noise_factor = options.gyro_noise_factor = 0.0;
  return options;
}

TEST(ImuQuality, QuadraticMotionHasNoNoiseWhateverTheStamps) {
  for (const Stream& stream : {Stream{}, Stream{100.0}, Stream{200.0, 1e-3, 0.01}}) {
    const ImuQuality quality =
        measureImuQuality(record(stream, quadratic, quadratic, {0.0, 0.0}, 1));
    ASSERT_TRUE(quality.measured());
    EXPECT_LT(quality.noise.gyro_density, 1e-12);
    EXPECT_LT(quality.noise.accel_density, 1e-12);
  }
}

TEST(ImuQuality, CubicMotionDoesNotVanish) {
  const auto cubic = [](double t) -> Vector3d { return Vector3d::Constant(t * t * t); };
  const ImuQuality quality = measureImuQuality(record({}, cubic, cubic, {0.0, 0.0}, 1));
  // Third difference 6 h^3 of samples h apart, over sqrt(20), times sqrt(h).
  EXPECT_NEAR(quality.noise.accel_density, 6.0 * std::pow(0.005, 3.5) / std::sqrt(20.0), 1e-13);
}

TEST(ImuQuality, WhiteNoiseIsRecovered) {
  for (const double rate : {200.0, 100.0}) {
    SCOPED_TRACE(rate);
    expectNoiseRecovered({rate}, quadratic, kSheet);
    expectNoiseRecovered({rate}, quadratic, {20 * 1.7e-4, 30 * 2e-3});
    // Jitter and missing samples do not matter.
    expectNoiseRecovered({rate, 2e-3, 0.01}, quadratic, kSheet);
    expectNoiseRecovered({rate, 2e-3, 0.05}, quadratic, kSheet);
  }
}

TEST(ImuQuality, WhiteNoiseIsRecoveredUnderMotionByHand) {
  // Motion leaves more of itself in the differences of slow samples.
  expectNoiseRecovered({200.0}, hand, {3 * 1.7e-4, 3 * 2e-3});
  expectNoiseRecovered({100.0}, hand, {10 * 1.7e-4, 10 * 2e-3});
}

TEST(ImuQuality, JitterThatTheStampsDoNotTellIsNoise) {
  std::vector<ImuSample> samples = record({200.0, 1e-3}, hand, hand, {0.0, 0.0}, 1);
  EXPECT_LT(measureImuQuality(samples).noise.accel_density, 1e-5);
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].t = k / 200.0;
  // 1 ms of a force that changes by 6 m/s^3 (rms of an axis), at 200 Hz.
  EXPECT_NEAR(measureImuQuality(samples).noise.accel_density, 6e-3 / std::sqrt(200.0), 2e-4);
}

TEST(ImuQuality, VibrationIsMeasuredAsWhatAveragingLeavesOfIt) {
  // 2 m/s^2 at 60 Hz: 1.41 rms, as white noise of the samples 0.1 m/s^2/sqrt(Hz).
  const auto vibrating = [](double t) -> Vector3d {
    return hand(t) + Vector3d::Constant(2.0 * std::sin(2.0 * M_PI * 61.3 * t));
  };
  const double quiet = measureImuQuality(record({}, hand, hand, kSheet, 1)).noise.accel_density;
  const double shaken =
      measureImuQuality(record({}, vibrating, vibrating, kSheet, 1)).noise.accel_density;
  EXPECT_GT(shaken, 3.0 * quiet);
  EXPECT_LT(shaken, 0.1);
  EXPECT_LT(quiet, 1.2 * kSheet.accel_density);
}

TEST(ImuQuality, OutliersDoNotCount) {
  std::vector<ImuSample> samples = record({}, quadratic, quadratic, kSheet, 1);
  const double clean = measureImuQuality(samples).noise.accel_density;
  for (std::size_t k = 20; k < samples.size(); k += 50) samples[k].accel.x() += 50.0;
  EXPECT_NEAR(measureImuQuality(samples).noise.accel_density, clean, 0.2 * clean);
}

TEST(ImuQuality, GapsAreLeftOut) {
  std::vector<ImuSample> samples = record({}, hand, hand, kSheet, 1);
  const ImuQuality whole = measureImuQuality(samples);
  samples.erase(samples.begin() + 200, samples.begin() + 209);
  const ImuQuality cut = measureImuQuality(samples);
  EXPECT_EQ(cut.differences, whole.differences - 12);  // nine samples less, three reach across
  EXPECT_NEAR(cut.noise.accel_density, whole.noise.accel_density, 0.1 * whole.noise.accel_density);
}

TEST(ImuQuality, MotionIsThatOfTheSamples) {
  const auto force = [](double t) -> Vector3d {
    return {3.0 * std::sin(2 * M_PI * t), 4.0 * std::cos(2 * M_PI * t), 9.8};
  };
  const auto rate = [](double) -> Vector3d { return {0.1, 0.2, 0.3}; };
  const ImuQuality quality =
      measureImuQuality(record({100.0, 0.0, 0.01, 4.0}, rate, force, {0.0, 0.0}, 1));
  EXPECT_NEAR(quality.force_spread, 5.0 / std::sqrt(2.0), 0.05);
  EXPECT_NEAR(quality.angular_spread, 0.0, 1e-12);  // a constant rate is like a bias
}

TEST(ImuQuality, FewSamplesAreNotMeasured) {
  for (const int n : {0, 1, 2, 4, 22}) {
    std::vector<ImuSample> samples = record({}, quadratic, quadratic, kSheet, 1);
    samples.resize(n);
    const ImuQuality quality = measureImuQuality(samples);
    EXPECT_FALSE(quality.measured()) << n;
    EXPECT_EQ(quality.differences, std::max(n - 3, 0));
  }
  std::vector<ImuSample> enough = record({}, quadratic, quadratic, kSheet, 1);
  enough.resize(23);
  EXPECT_TRUE(measureImuQuality(enough).measured());
}

TEST(AssumedImuNoise, WithoutMeasurementItIsTheDataSheetAndTheMotion) {
  const ImuNoise at_rest = assumedImuNoise(kSheet, ImuQuality(), measuredNoise());
  EXPECT_DOUBLE_EQ(at_rest.gyro_density, kSheet.gyro_density);
  EXPECT_DOUBLE_EQ(at_rest.accel_density, 2.0 * kSheet.accel_density);
}

TEST(AssumedImuNoise, GrowsWithMeasuredNoiseAndWithMotionAndNeverFallsBelowTheDataSheet) {
  const auto assumed = [](const ImuNoise& measured, double force, double rate) {
    ImuQuality quality;
    quality.noise = measured;
    quality.force_spread = force;
    quality.angular_spread = rate;
    return assumedImuNoise(kSheet, quality, measuredNoise());
  };
  const ImuNoise floor = assumed({0.0, 0.0}, 0.0, 0.0);
  EXPECT_DOUBLE_EQ(floor.gyro_density, kSheet.gyro_density);
  EXPECT_DOUBLE_EQ(floor.accel_density, 2.0 * kSheet.accel_density);
  const ImuNoise vibrating = assumed({1e-3, 3e-2}, 0.0, 0.0);
  EXPECT_GT(vibrating.gyro_density, floor.gyro_density);
  EXPECT_GT(vibrating.accel_density, floor.accel_density);
  const ImuNoise moving = assumed({1e-3, 3e-2}, 1.5, 0.5);
  EXPECT_GT(moving.gyro_density, vibrating.gyro_density);
  EXPECT_GT(moving.accel_density, vibrating.accel_density);
  // A recorded flight (EuRoC V1_01): what the constants 10 and 3 stood for.
  const ImuNoise flight = assumed({5.8 * 1.7e-4, 15 * 2e-3}, 1.5, 0.3);
  EXPECT_NEAR(flight.accel_density / kSheet.accel_density, 10.0, 1.0);
  EXPECT_NEAR(flight.gyro_density / kSheet.gyro_density, 2.1, 0.3);
}

TEST(AssumedImuNoise, AFactorReplacesTheMeasurementOfItsSensorOnly) {
  ImuQuality quality;
  quality.noise = {1e-3, 3e-2};
  quality.force_spread = 1.5;
  quality.angular_spread = 0.5;
  InertialOptions options = measuredNoise();
  const ImuNoise measured = assumedImuNoise(kSheet, quality, options);
  options.accel_noise_factor = 10.0;
  EXPECT_DOUBLE_EQ(assumedImuNoise(kSheet, quality, options).accel_density,
                   10.0 * kSheet.accel_density);
  EXPECT_EQ(assumedImuNoise(kSheet, quality, options).gyro_density, measured.gyro_density);
  options = measuredNoise();
  options.gyro_noise_factor = 3.0;
  EXPECT_DOUBLE_EQ(assumedImuNoise(kSheet, quality, options).gyro_density,
                   3.0 * kSheet.gyro_density);
  EXPECT_EQ(assumedImuNoise(kSheet, quality, options).accel_density, measured.accel_density);
}

}  // namespace
}  // namespace slim_init
