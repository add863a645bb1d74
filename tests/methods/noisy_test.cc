// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Noisy windows within named tolerances, over many seeds.
#include <gtest/gtest.h>

#include <algorithm>

#include "slim_init/baselines/baselines.h"
#include "support/exact_window.h"
#include "support/method_name.h"

namespace slim_init {
namespace {

using namespace testing_support;  // NOLINT: the vocabulary of these tests

// Accelerations of 1.4 m/s^2 over 2.25 s, 100 points at 0.6 px, EuRoC's IMU, no accelerometer bias.
constexpr double kMedianScaleError = 0.03;
constexpr double kWorstScaleError = 0.12;
constexpr double kMedianGravityErrorDeg = 0.3;

class Noisy : public ::testing::TestWithParam<std::string> {};

TEST_P(Noisy, StaysWithinTolerance) {
  const auto solver = baselines::makeMethod(GetParam(), InitializerOptions());
  std::vector<double> scale, gravity;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    ExactWindowOptions options;
    options.seed = seed;
    options.pixel_noise = 0.6;
    options.imu_noise = true;
    const ExactWindow exact = makeExactWindow(options);
    const InitResult result = solver->solve(*exact.window);
    ASSERT_TRUE(result.hasEstimate()) << "seed " << seed << ": " << result.message;
    scale.push_back(std::abs(scaleError(result.states, exact.truth)));
    gravity.push_back(gravityErrorRad(result.gravity_b0, exact.truth[0]) * 180.0 / M_PI);
  }
  std::sort(scale.begin(), scale.end());
  std::sort(gravity.begin(), gravity.end());
  EXPECT_LT(scale[15], kMedianScaleError);
  EXPECT_LT(scale.back(), kWorstScaleError);
  EXPECT_LT(gravity[15], kMedianGravityErrorDeg);
}

INSTANTIATE_TEST_SUITE_P(Methods, Noisy,
                         ::testing::ValuesIn(baselines::namesOf(baselines::methods())),
                         methodTestName);

}  // namespace
}  // namespace slim_init
