// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Noisy windows within named tolerances, over many seeds.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "methods/method_checks.h"
#include "slim_init/baselines/baselines.h"
#include "support/chi_square.h"
#include "support/method_name.h"

namespace slim_init {
namespace {

class Noisy : public ::testing::TestWithParam<std::string> {};

TEST_P(Noisy, StaysWithinTolerance) {
  const NoisyErrors errors(*baselines::makeMethod(GetParam(), InitializerOptions()), 30);
  ASSERT_EQ(errors.scale.size(), 30u);
  EXPECT_LT(errors.scale[15], 0.03);
  EXPECT_LT(errors.scale.back(), 0.12);
  EXPECT_LT(errors.gravity_deg[15], 0.3);
}

// Over many windows, scale, biases, speed and distance of `slim` miss the truth by as much as it
// reports.
TEST(Noisy, SlimsStandardDeviationsAreThoseOfItsErrors) {
  InitializerOptions slim_options;
  // The simulated IMU is as good as its data sheet, the tracks do not drift.
  slim_options.inertial.accel_noise_factor = 1.0;
  slim_options.inertial.gyro_noise_factor = 1.0;
  slim_options.refinement.min_sigma_px = 0.01;
  const auto solver = baselines::makeMethod("slim", slim_options);
  double scale = 0.0, gyro_bias = 0.0, accel_bias = 0.0, speed = 0.0, distance = 0.0;
  constexpr int kWindows = 200;
  for (unsigned seed = 1; seed <= kWindows; ++seed) {
    const ExactWindow exact =
        makeExactWindow(drawnFromTheModel(seed, slim_options.inertial.accel_bias_prior));
    const InitResult result = solver->solve(*exact.window);
    ASSERT_TRUE(result.success()) << "seed " << seed << ": " << result.message;
    scale += std::pow(scaleError(result.states, exact.truth) / result.scale_sigma, 2);
    const int n = static_cast<int>(result.states.size());
    const auto squared = [&](const Eigen::Vector3d& error, int at) {
      return error.dot(result.covariance.block<3, 3>(at, at).llt().solve(error));
    };
    gyro_bias += squared(result.gyro_bias - exact.truth[0].gyro_bias, 9 * n);
    accel_bias += squared(result.states[0].accel_bias - exact.truth[0].accel_bias, 9 * n + 3);
    // Lengths, which do not depend on the yaw between the worlds of answer and truth.
    const auto squared_length = [&](const Eigen::Vector3d& x, const Eigen::Vector3d& truth,
                                    int at) {
      const Eigen::Vector3d along = x.normalized();
      return std::pow(x.norm() - truth.norm(), 2) /
             along.dot(result.covariance.block<3, 3>(at, at) * along);
    };
    const NavState &last = result.states[n - 1], &last_truth = exact.truth[n - 1];
    speed += squared_length(last.v_w_b, last_truth.v_w_b, 9 * (n - 1) + 6);
    distance += squared_length(last.p_w_b - result.states[0].p_w_b,
                               last_truth.p_w_b - exact.truth[0].p_w_b, 9 * (n - 1) + 3);
  }
  EXPECT_TRUE(isChiSquare(scale, kWindows)) << "scale";
  EXPECT_TRUE(isChiSquare(gyro_bias, 3 * kWindows)) << "gyroscope bias";
  EXPECT_TRUE(isChiSquare(accel_bias, 3 * kWindows)) << "accelerometer bias";
  EXPECT_TRUE(isChiSquare(speed, kWindows)) << "speed";
  EXPECT_TRUE(isChiSquare(distance, kWindows)) << "distance";
}

INSTANTIATE_TEST_SUITE_P(Methods, Noisy,
                         ::testing::ValuesIn(baselines::namesOf(baselines::methods())),
                         methodTestName);

}  // namespace
}  // namespace slim_init
