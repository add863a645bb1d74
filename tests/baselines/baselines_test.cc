// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The compared systems `vins` and `openvins`: exact without noise, within named tolerances with it,
// refusals where their papers refuse, and the same answer for the same data.
#include "slim_init/baselines/baselines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "support/exact_window.h"
#include "support/method_name.h"
#include "support/option_checks.h"
#include "support/same_result.h"

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
      ExactWindowOptions options;
      options.seed = seed;
      options.interval_s = interval;
      const ExactWindow exact = makeExactWindow(options);
      SCOPED_TRACE("seed " + std::to_string(seed) + ", interval " + std::to_string(interval));
      const InitResult result = solve(exact);
      ASSERT_TRUE(result.success()) << result.message;
      double path = 0.0, speed = 0.0;
      for (const NavState& state : exact.truth) {
        speed = std::max(speed, state.v_w_b.norm());
        path = std::max(path, (state.p_w_b - exact.truth[0].p_w_b).norm());
      }
      EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), kNoiseFree);
      EXPECT_LT(gravityErrorRad(result.gravity_b0, exact.truth[0]), kNoiseFree);
      EXPECT_LT(velocityRmse(result.states, exact.truth), kNoiseFree * speed);
      EXPECT_LT(positionRmse(result.states, exact.truth), kNoiseFree * path);
      EXPECT_LT((result.gyro_bias - options.gyro_bias).norm(),
                kNoiseFree * options.gyro_bias.norm());
      EXPECT_LT(result.states[0].p_w_b.norm(), 1e-12);
    }
  }
}

// Accelerations of 1.4 m/s^2 over 2.25 s, 100 points at 0.6 px, EuRoC's IMU, no accelerometer bias.
constexpr double kMedianScaleError = 0.03;
constexpr double kMedianGravityErrorDeg = 1.0;

TEST_P(Baselines, StayWithinToleranceWithNoise) {
  std::vector<double> scale, gravity;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const ExactWindow exact = noisyWindow(Motion::kExcited, seed);
    const InitResult result = solve(exact);
    ASSERT_TRUE(result.hasEstimate()) << "seed " << seed << ": " << result.message;
    scale.push_back(std::abs(scaleError(result.states, exact.truth)));
    gravity.push_back(gravityErrorRad(result.gravity_b0, exact.truth[0]) * 180.0 / M_PI);
  }
  std::sort(scale.begin(), scale.end());
  std::sort(gravity.begin(), gravity.end());
  EXPECT_LT(scale[10], kMedianScaleError);
  EXPECT_LT(gravity[10], kMedianGravityErrorDeg);
}

TEST_P(Baselines, ReportStagesAndCounts) {
  const InitResult result = solve(noisyWindow(Motion::kExcited, 1));
  EXPECT_GE(result.stages.size(), 3u);
  EXPECT_EQ(result.counts.keyframes, 10);
  EXPECT_GT(result.counts.point_tracks, 50);
}

TEST_P(Baselines, AcceptExcitedMotionWithTheProjectsGates) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const InitResult result = solve(noisyWindow(Motion::kExcited, seed), GateMode::kOn);
    EXPECT_EQ(result.status, InitStatus::kSuccess) << "seed " << seed << ": " << result.message;
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
  ExactWindow exact = makeExactWindow(ExactWindowOptions());
  for (FrameObservation& frame : exact.keyframes) {
    for (PointObservation& point : frame.points) point.bearing = Eigen::Vector3d::UnitZ();
  }
  exact.window = InitWindow::create(exact.calibration, exact.keyframes, exact.imu);
  ASSERT_NE(exact.window, nullptr);
  const InitResult result = solve(exact, GateMode::kOn);
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

TEST(VinsRefusals, HoverHasTooLittleParallax) {
  ExactWindowOptions options;
  options.motion = Motion::kHover;
  options.pixel_noise = 0.6;
  const InitResult result = makeMethod("vins", InitializerOptions(), {}, nullptr, allMethods())
                                ->solve(*makeExactWindow(options).window);
  EXPECT_EQ(result.status, InitStatus::kTooLittleExcitation) << result.message;
  EXPECT_NE(result.message.find("(minimum 30)"), std::string::npos) << result.message;
  EXPECT_FALSE(result.hasEstimate());
}

TEST(OpenVinsRefusals, WithoutRotationItWaits) {
  ExactWindowOptions options;
  options.motion = Motion::kConstantVelocity;
  options.gyro_bias.setZero();
  const InitResult result = makeMethod("openvins", InitializerOptions(), {}, nullptr, allMethods())
                                ->solve(*makeExactWindow(options).window);
  EXPECT_EQ(result.status, InitStatus::kTooLittleExcitation) << result.message;
  EXPECT_NE(result.message.find("(minimum 10)"), std::string::npos) << result.message;
  EXPECT_FALSE(result.hasEstimate());
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
  BaselineOptions bad;
  bad.vins.ransac_threshold_px = 0.0;
  EXPECT_EQ(makeMethod("vins", InitializerOptions(), bad, &error, allMethods()), nullptr);
  EXPECT_NE(error.find("vins.ransac_threshold_px is 0"), std::string::npos) << error;
  bad = BaselineOptions();
  bad.openvins.sigma_px = -1.0;
  EXPECT_EQ(makeMethod("openvins", InitializerOptions(), bad, &error, allMethods()), nullptr);
  EXPECT_NE(error.find("openvins.sigma_px is -1"), std::string::npos) << error;
  bad = BaselineOptions();
  bad.alignment_gates.min_linkage = 0.0;
  EXPECT_EQ(makeMethod("vins", InitializerOptions(), bad, &error, allMethods()), nullptr);
  EXPECT_NE(error.find("alignment_gates.min_linkage"), std::string::npos) << error;
  InitializerOptions initializer;
  initializer.gates.min_excitation = -1.0;
  EXPECT_EQ(makeMethod("vins", initializer, BaselineOptions(), &error, allMethods()), nullptr);
  EXPECT_NE(error.find("gates.min_excitation"), std::string::npos) << error;
  for (const std::string& name : namesOf(allMethods())) {
    EXPECT_EQ(makeMethod(name, InitializerOptions(), {}, nullptr, allMethods())->name(), name);
  }
}

TEST(BaselineOptions, TableHasEveryFieldAndValidateKeepsItsBounds) {
  expectBothSidesOfEveryBound<BaselineOptions>();
  expectEveryFieldHasARow<BaselineOptions>();
}

}  // namespace
}  // namespace slim_init::baselines
