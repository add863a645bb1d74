// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/motion_sensors.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "support/made_trajectory.h"

namespace slim_init::simulation {
namespace {

MadeTrajectory still(double duration) {
  return {0.0, duration, [](double) { return Kinematics(); }};
}

ImuSimulationOptions noiseFree() {
  ImuSimulationOptions options;
  options.noise = {0.0, 0.0};
  options.gyro_bias.setZero();
  options.accel_bias.setZero();
  return options;
}

TEST(ImuSimulator, SamplesAtTheRateFromTheBegin) {
  const MadeTrajectory trajectory(10.0, 12.0, [](double) { return Kinematics(); });
  ImuSimulationOptions options;
  options.rate_hz = 400.0;
  const std::vector<ImuSample> imu = simulateImu(trajectory, options);
  ASSERT_EQ(imu.size(), 801U);
  for (std::size_t k = 0; k < imu.size(); ++k) EXPECT_EQ(imu[k].t, 10.0 + k / 400.0);
  options.rate_hz = 300.0;  // the period is not a binary fraction
  EXPECT_EQ(simulateImu(trajectory, options).size(), 601U);
}

TEST(ImuSimulator, FeelsWhatTheMotionSays) {
  using Eigen::Matrix3d, Eigen::Vector3d;
  const Matrix3d level = Matrix3d::Identity();
  const Matrix3d tilted =
      Eigen::AngleAxisd(1.1, Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  Matrix3d left;  // body x points along world y
  left << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Vector3d zero = Vector3d::Zero(), up(0.0, 0.0, 9.81007), turn(0.1, 0.2, 0.3);
  const struct {
    const char* name;
    Matrix3d R_w_b;
    Vector3d a_w_b, omega_b, gyro_bias, accel_bias, gyro, accel;
  } cases[] = {
      {"rest", tilted, zero, zero, zero, zero, zero, tilted.transpose() * up},
      {"free fall", level, -up, zero, zero, zero, zero, zero},
      {"forwards", left, {0.0, 2.0, 0.0}, turn, zero, zero, turn, {2.0, 0.0, 9.81007}},
      {"biases", level, zero, zero, turn, {-0.1, 0.2, 0.3}, turn, {-0.1, 0.2, 10.11007}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    Kinematics motion;
    motion.R_w_b = c.R_w_b;
    motion.a_w_b = c.a_w_b;
    motion.omega_b = c.omega_b;
    ImuSimulationOptions options = noiseFree();
    options.gyro_bias = c.gyro_bias;
    options.accel_bias = c.accel_bias;
    for (const ImuSample& s :
         simulateImu(MadeTrajectory(0.0, 1.0, [&](double) { return motion; }), options)) {
      EXPECT_EQ(s.gyro, c.gyro);
      EXPECT_LT((s.accel - c.accel).norm(), 1e-12);
    }
  }
}

TEST(ImuSimulator, NoiseIsWhiteWithTheDensityGiven) {
  ImuSimulationOptions options = noiseFree();
  options.noise.gyro_density = 1.7e-4;
  options.noise.accel_density = 2.0e-3;
  for (const double rate_hz : {100.0, 400.0}) {
    options.rate_hz = rate_hz;
    const std::vector<ImuSample> imu = simulateImu(still(100000.0 / rate_hz), options);
    const double n = static_cast<double>(imu.size());
    // Rows gyro x, y, z, accel x, y, z in units of the expected sigma.
    Eigen::MatrixXd z(6, imu.size());
    for (std::size_t k = 0; k < imu.size(); ++k) {
      z.col(k).head<3>() = imu[k].gyro / (1.7e-4 * std::sqrt(rate_hz));
      z.col(k).tail<3>() =
          (imu[k].accel - Eigen::Vector3d(0, 0, 9.81007)) / (2.0e-3 * std::sqrt(rate_hz));
    }
    // Five standard deviations of a mean, a correlation (1/sqrt n) and a sigma (1/sqrt 2n).
    const double tolerance = 5.0 / std::sqrt(n);
    const Eigen::MatrixXd covariance = z * z.transpose() / n;
    const Eigen::MatrixXd lagged =
        z.rightCols(imu.size() - 1) * z.leftCols(imu.size() - 1).transpose() / n;
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(z.row(i).mean(), 0.0, tolerance) << i;
      EXPECT_NEAR(std::sqrt(covariance(i, i)), 1.0, tolerance / std::sqrt(2.0)) << i;
      for (int j = 0; j < 6; ++j) {
        EXPECT_NEAR(lagged(i, j), 0.0, tolerance) << i << ' ' << j;
        if (i == j) continue;
        EXPECT_NEAR(covariance(i, j), 0.0, tolerance) << i << ' ' << j;
      }
      // A normal distribution: kurtosis 3, standard error sqrt(24 / n).
      EXPECT_NEAR(z.row(i).array().pow(4).mean(), 3.0, 5.0 * std::sqrt(96.0 / n)) << i;
    }
  }
}

TEST(ImuSimulator, EqualSeedsGiveEqualBytesOfIndependentStreams) {
  ImuSimulationOptions options;
  const std::vector<ImuSample> both = simulateImu(still(2.0), options);
  ImuSimulationOptions no_accel_noise = options;
  no_accel_noise.noise.accel_density = 0.0;
  ImuSimulationOptions no_gyro_noise = options;
  no_gyro_noise.noise.gyro_density = 0.0;
  const std::vector<ImuSample> gyro_only = simulateImu(still(2.0), no_accel_noise);
  const std::vector<ImuSample> accel_only = simulateImu(still(2.0), no_gyro_noise);
  options.seed = 2;
  const std::vector<ImuSample> other = simulateImu(still(2.0), options);
  for (std::size_t k = 0; k < both.size(); ++k) {
    ASSERT_EQ(both[k].gyro, gyro_only[k].gyro);
    ASSERT_NE(both[k].accel, gyro_only[k].accel);
    ASSERT_EQ(both[k].accel, accel_only[k].accel);
    ASSERT_NE(both[k].gyro, accel_only[k].gyro);
    ASSERT_NE(both[k].gyro, other[k].gyro);
    ASSERT_NE(both[k].accel, other[k].accel);
  }
}

TEST(ImuSimulator, IntegratesBackToTheTrajectory) {
  const auto trajectory =
      makeBuiltinTrajectory("figure-eight", 10.0, Eigen::Matrix3d::Identity(), 1, nullptr);
  ImuSimulationOptions options = noiseFree();
  options.rate_hz = 1000.0;
  const std::vector<ImuSample> imu = simulateImu(*trajectory, options);
  Kinematics state = trajectory->at(0.0);
  const Eigen::Vector3d g_w(0.0, 0.0, -9.81007);
  const double dt = 1e-3;
  for (std::size_t k = 0; k + 1 < imu.size(); ++k) {
    const Eigen::Vector3d phi = 0.5 * (imu[k].gyro + imu[k + 1].gyro) * dt;
    const Eigen::Matrix3d next =
        state.R_w_b * Eigen::AngleAxisd(phi.norm(), phi.normalized()).toRotationMatrix();
    const Eigen::Vector3d a_w = 0.5 * (state.R_w_b * imu[k].accel + next * imu[k + 1].accel) + g_w;
    state.p_w_b += dt * state.v_w_b + 0.5 * dt * dt * a_w;
    state.v_w_b += dt * a_w;
    state.R_w_b = next;
  }
  const Kinematics truth = trajectory->at(10.0);
  constexpr double kTrapezoid = 1e-4;  // [m, m/s, rad] remainder over 10 s at 1 ms
  EXPECT_LT((state.p_w_b - truth.p_w_b).norm(), kTrapezoid);
  EXPECT_LT((state.v_w_b - truth.v_w_b).norm(), kTrapezoid);
  EXPECT_LT((state.R_w_b - truth.R_w_b).norm(), kTrapezoid);
}

}  // namespace
}  // namespace slim_init::simulation
