// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The compared systems `vins` and `openvins`: exact without noise, within named tolerances with it,
// refusals where their papers refuse, and the same answer for the same data.
#include "slim_init/baselines/baselines.h"

#include <gtest/gtest.h>

#include <thread>

#include "methods/method_checks.h"
#include "support/method_name.h"
#include "support/same_result.h"
#include "support/text_parts.h"

namespace slim_init::baselines {
namespace {

class Baselines : public ::testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<WindowSolver> make(GateMode mode = GateMode::kOwn) const {
    InitializerOptions options;
    options.gates.mode = mode;
    return makeMethod(GetParam(), options, {}, nullptr, allMethods());
  }
  InitResult solve(const ExactWindow& exact, GateMode mode = GateMode::kOwn) const {
    return make(mode)->solve(*exact.window);
  }
};

INSTANTIATE_TEST_SUITE_P(Methods, Baselines, ::testing::Values("vins", "openvins"), methodTestName);

// Both end their minimisations by a relative decrease of the cost.
constexpr double kNoiseFree = 1e-4;

TEST_P(Baselines, RecoverNoiseFreeWindows) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (double interval : {0.25, 0.4}) {
      ExactWindowOptions options = seeded(seed);
      options.interval_s = interval;
      const ExactWindow exact = makeExactWindow(options);
      SCOPED_TRACE("seed " + std::to_string(seed) + ", interval " + std::to_string(interval));
      expectRecovered(exact, solve(exact), kNoiseFree);
    }
  }
}

TEST_P(Baselines, StayWithinToleranceWithNoise) {
  const NoisyErrors errors(*make(), 20);
  ASSERT_EQ(errors.scale.size(), 20u);
  EXPECT_LT(errors.scale[10], 0.03);
  EXPECT_LT(errors.gravity_deg[10], 1.0);
}

TEST_P(Baselines, AcceptExcitedMotionWithTheProjectsGates) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const InitResult result = solve(noisyWindow(Motion::kExcited, seed), GateMode::kOn);
    EXPECT_EQ(result.status, InitStatus::kSuccess) << "seed " << seed << ": " << result.message;
    EXPECT_GE(result.stages.size(), 3u);
    EXPECT_EQ(result.counts.keyframes, 10);
    EXPECT_GT(result.counts.point_tracks, 50);
  }
}

TEST_P(Baselines, AcceptNoDegenerateMotionWithTheProjectsGates) {
  for (Motion motion : {Motion::kHover, Motion::kPureRotation, Motion::kConstantVelocity}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const InitResult result = solve(noisyWindow(motion, seed), GateMode::kOn);
      EXPECT_NE(result.status, InitStatus::kSuccess)
          << static_cast<int>(motion) << " seed " << seed << ": " << result.message;
      EXPECT_FALSE(result.message.empty());
    }
  }
}

TEST_P(Baselines, RefuseWindowsWithTooFewPoints) {
  for (int points : {0, 3, 7}) {
    ExactWindowOptions options;
    options.points = points;
    const InitResult result = solve(makeExactWindow(options));
    EXPECT_EQ(result.status, InitStatus::kTooFewTracks) << points << ": " << result.message;
    EXPECT_FALSE(result.hasEstimate());
  }
}

TEST_P(Baselines, RefuseWindowsWithTooFewKeyframes) {
  ExactWindowOptions options;
  options.keyframes = 3;
  const InitResult result = solve(makeExactWindow(options));
  EXPECT_EQ(result.status, InitStatus::kTooFewKeyframes) << result.message;
}

TEST_P(Baselines, SurviveParallelBearings) {
  const InitResult result = make(GateMode::kOn)->solve(*windowOfParallelBearings());
  EXPECT_NE(result.status, InitStatus::kSuccess) << result.message;
}

TEST_P(Baselines, GiveEqualBytesForEqualInputAlsoInParallel) {
  const ExactWindow exact = noisyWindow(Motion::kExcited, 1);
  const auto solver = make();
  const InitResult first = solver->solve(*exact.window);
  solver->solve(*noisyWindow(Motion::kExcited, 99).window);
  EXPECT_TRUE(sameBytes(first, solver->solve(*exact.window)));
  std::vector<InitResult> results(4);
  std::vector<std::thread> threads;
  for (InitResult& result : results) {
    threads.emplace_back([&] { result = solver->solve(*exact.window); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const InitResult& result : results) EXPECT_TRUE(sameBytes(first, result));
}

TEST_P(Baselines, DoNotCareForYawAndOriginOfTheWorld) {
  ExactWindowOptions moved;
  moved.yaw_rad = -2.1;
  moved.origin = Eigen::Vector3d(100, -50, 7);
  const InitResult a = solve(makeExactWindow(ExactWindowOptions()));
  const InitResult b = solve(makeExactWindow(moved));
  ASSERT_TRUE(a.success() && b.success());
  EXPECT_NEAR(a.scale, b.scale, kNoiseFree);
  EXPECT_LT((a.gravity_b0 - b.gravity_b0).norm(), kNoiseFree * 9.81);
}

// The refusals of the methods themselves.
TEST(BaselineRefusals, VinsAtHoverAndOpenVinsWithoutRotation) {
  ExactWindowOptions hover, straight;
  hover.motion = Motion::kHover;
  hover.pixel_noise = 0.6;
  straight.motion = Motion::kConstantVelocity;
  straight.gyro_bias.setZero();
  const std::tuple<const char*, ExactWindowOptions, const char*> cases[] = {
      {"vins", hover, "(minimum 30)"}, {"openvins", straight, "(minimum 10)"}};
  for (const auto& [method, options, bound] : cases) {
    const InitResult result = makeMethod(method, InitializerOptions(), {}, nullptr, allMethods())
                                  ->solve(*makeExactWindow(options).window);
    EXPECT_EQ(result.status, InitStatus::kTooLittleExcitation) << result.message;
    expectParts(result.message, bound);
    EXPECT_FALSE(result.hasEstimate());
  }
}

TEST(MakeBaseline, RefusesUnknownNamesAndBadOptions) {
  std::string error;
  EXPECT_EQ(makeMethod("sfm", InitializerOptions(), {}, &error, allMethods()), nullptr);
  EXPECT_EQ(error,
            "unknown method \"sfm\", must be one of: slim slim-paper drt-l drt-t drt-vi-ba vins "
            "openvins");
  // Without Ceres.
  EXPECT_EQ(makeMethod("vins", InitializerOptions(), {}, &error), nullptr);
  EXPECT_EQ(error,
            "unknown method \"vins\", must be one of: slim slim-paper drt-l drt-t drt-vi-ba");
  InitializerOptions bad;
  bad.gates.min_excitation = -1.0;
  EXPECT_EQ(makeMethod("vins", bad, {}, &error, allMethods()), nullptr);
  expectParts(error, "gates.min_excitation");
  for (const std::string& name : namesOf(allMethods())) {
    EXPECT_EQ(makeMethod(name, InitializerOptions(), {}, nullptr, allMethods())->name(), name);
  }
}

}  // namespace
}  // namespace slim_init::baselines
