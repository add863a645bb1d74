// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is learned of the sensors in flight, and what it is worth later.
#include "sensor_memory.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim_init::vins_adapter {
namespace {

using Eigen::Vector3d;

constexpr double kStart = 1.7e9;  // as ROS has it

HostState healthyAt(double t) {
  HostState state;
  state.stamp = kStart + t;
  state.Bg = Vector3d(0.01, 0.02, 1e-6 * t);
  state.Ba = Vector3d(0.1, 0.2, 1e-3 * t);
  return state;
}

// Frames at 10 Hz from the one time to the other.
void fly(double from, double to, SensorMemory* memory,
         const OptionalCalibration& calibration = OptionalCalibration()) {
  for (int k = static_cast<int>(std::lround(from * 10)); k <= std::lround(to * 10); ++k) {
    memory->learn(healthyAt(0.1 * k), calibration);
  }
}

bool knowsBiases(const SensorMemory& memory, double t) {
  return std::isfinite(memory.knownAt(kStart + t).biases.gyro_sigma);
}

TEST(SensorMemory, BelievesABiasAfterTwentySecondsOfFlightAndInHindsight) {
  SensorMemory memory{Calibration()};
  EXPECT_FALSE(knowsBiases(memory, 0.0));
  fly(0.0, 20.9, &memory);
  EXPECT_FALSE(knowsBiases(memory, 20.9));
  fly(21.0, 21.0, &memory);
  ASSERT_TRUE(knowsBiases(memory, 21.0));
  EXPECT_EQ(memory.learned().stamp, kStart + 20.0);
  EXPECT_EQ(memory.learned().known.biases.accel, healthyAt(20.0).Ba);
  // What came in the last second before a failure is not believed.
  fly(21.1, 30.4, &memory);
  EXPECT_NEAR(memory.learned().stamp, kStart + 29.0, 1e-6);
}

TEST(SensorMemory, AnotherFlightBeginsAnewAndKeepsWhatIsKnown) {
  SensorMemory memory{Calibration()};
  fly(0.0, 15.0, &memory);
  fly(16.2, 35.0, &memory);  // interrupted
  EXPECT_FALSE(knowsBiases(memory, 35.0));
  fly(35.1, 37.3, &memory);
  ASSERT_TRUE(knowsBiases(memory, 37.3));
  const double known = memory.learned().stamp;
  fly(60.0, 65.0, &memory);
  EXPECT_EQ(memory.learned().stamp, known);
  fly(3.0, 4.0, &memory);  // the streams have begun anew
  EXPECT_EQ(memory.learned().stamp, known);
}

TEST(SensorMemory, KnowsLessWithTimeAndAfterARestart) {
  SensorMemory memory{Calibration()};
  fly(0.0, 21.0, &memory);
  const ImuBiases at_once = memory.knownAt(kStart + 20.0).biases;
  EXPECT_EQ(at_once.gyro_sigma, SensorMemory::kGyroSigma);
  EXPECT_EQ(at_once.accel_sigma, SensorMemory::kAccelSigma);
  const ImuBiases later = memory.knownAt(kStart + 120.0).biases;
  EXPECT_NEAR(later.accel_sigma, std::hypot(SensorMemory::kAccelSigma, 0.06), 1e-9);
  EXPECT_NEAR(later.gyro_sigma, std::hypot(SensorMemory::kGyroSigma, 2e-3), 1e-9);
  EXPECT_EQ(later.accel, at_once.accel);
  SensorMemory restarted = memory;
  restarted.restart();
  const ImuBiases after = restarted.knownAt(kStart - 1e6).biases;
  EXPECT_NEAR(after.accel_sigma, std::hypot(SensorMemory::kAccelSigma, SensorMemory::kAccelTurnOn),
              1e-9);
  EXPECT_NEAR(after.gyro_sigma, std::hypot(SensorMemory::kGyroSigma, SensorMemory::kGyroTurnOn),
              1e-9);
  // A flight of its own, and they are this run's.
  fly(0.0, 21.0, &restarted);
  EXPECT_EQ(restarted.knownAt(kStart + 20.0).biases.accel_sigma, SensorMemory::kAccelSigma);
}

TEST(SensorMemory, KeepsOfACalibrationWhatIsBetterKnownThanTheFile) {
  const CalibrationSigmas care;
  OptionalCalibration found;
  found.emplace().td = 0.02;
  found->t_b_c = Vector3d(0.1, 0.2, 0.3);
  found->covariance.diagonal().setConstant(1e-12);
  found->covariance(6, 6) = 0.01 * 0.01;
  // A file that is as good as any: nothing.
  Calibration configured;
  SensorMemory careful{configured};
  careful.learn(found);
  EXPECT_FALSE(careful.knownAt(kStart).calibration.has_value());
  // One that says td is a guess: td.
  configured.sigmas.td_s = 0.03;
  SensorMemory memory{configured};
  memory.learn(found);
  KnownSensors known = memory.knownAt(kStart);
  ASSERT_TRUE(known.calibration.has_value());
  EXPECT_EQ(known.calibration->td, 0.02);
  EXPECT_NEAR(known.calibration->tdSigma(), 0.01, 1e-12);
  EXPECT_EQ(known.calibration->t_b_c, configured.t_b_c);
  EXPECT_NEAR(known.calibration->rotationSigmaDeg(), care.rotation_deg, 1e-9);
  EXPECT_FALSE(std::isfinite(known.biases.accel_sigma));
  EXPECT_EQ(known.validate(), "");
  // That of a host that estimates it takes its place with the biases.
  found->td = 0.03;
  fly(0.0, 21.0, &memory, found);
  EXPECT_EQ(memory.knownAt(kStart + 21.0).calibration->td, 0.03);
  memory.learn(OptionalCalibration());  // a method without one
  EXPECT_EQ(memory.knownAt(kStart + 21.0).calibration->td, 0.03);
  // One that says nothing of the rotation: as if it had been measured with care.
  configured.sigmas = {180.0, 0.05, 0.0, 0.0};
  SensorMemory unknown{configured};
  unknown.learn(found);
  known = unknown.knownAt(kStart);
  ASSERT_TRUE(known.calibration.has_value());
  EXPECT_NEAR(known.calibration->rotationSigmaDeg(), care.rotation_deg, 1e-9);
  EXPECT_EQ(known.calibration->t_b_c, found->t_b_c);
  EXPECT_EQ(known.calibration->covariance(6, 6), 0.0) << "the file's td is exact";
  // Extrinsics that come without a td leave the file's.
  configured.td = 0.007;
  configured.sigmas.td_s = 0.03;
  SensorMemory extrinsics{configured};
  found->td = 0.0;
  found->covariance(6, 6) = 0.0;
  extrinsics.learn(found);
  known = extrinsics.knownAt(kStart);
  ASSERT_TRUE(known.calibration.has_value());
  EXPECT_EQ(known.calibration->td, configured.td);
  EXPECT_EQ(known.calibration->covariance(6, 6), 0.0);
}

}  // namespace
}  // namespace slim_init::vins_adapter
