// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Motions and data from which no scale can be had: the status says so, and what is observable is
// returned.
#include <gtest/gtest.h>

#include "methods/method_checks.h"
#include "slim_init/baselines/baselines.h"
#include "support/method_name.h"

namespace slim_init {
namespace {

class Degenerate : public ::testing::TestWithParam<std::string> {
 protected:
  InitResult solve(const InitWindow& window, GateMode mode = GateMode::kOn) const {
    InitializerOptions options;
    options.gates.mode = mode;
    return baselines::makeMethod(GetParam(), options)->solve(window);
  }
  InitResult solve(const ExactWindow& exact, GateMode mode = GateMode::kOn) const {
    return solve(*exact.window, mode);
  }
  // Ten noisy windows of a motion, each with its status.
  void expectStatus(Motion motion, InitStatus status) const {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const InitResult result = solve(noisyWindow(motion, seed));
      EXPECT_EQ(result.status, status) << "seed " << seed << ": " << result.message;
    }
  }
};

TEST_P(Degenerate, HoverIsStationaryWithGravityAndGyroBias) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ExactWindow exact = noisyWindow(Motion::kHover, seed);
    const InitResult result = solve(exact);
    EXPECT_EQ(result.status, InitStatus::kStationary) << result.message;
    EXPECT_FALSE(result.hasEstimate());
    EXPECT_TRUE(std::isnan(result.scale));
    EXPECT_LT(gravityErrorRad(result.gravity_b0, exact.truth[0]), 0.5 * M_PI / 180);
    EXPECT_LT((result.gyro_bias - exact.truth[0].gyro_bias).norm(), 2e-3);
    EXPECT_TRUE(isWait(result.status));
  }
}

TEST_P(Degenerate, PureRotationIsNamedWithItsGyroBias) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ExactWindow exact = noisyWindow(Motion::kPureRotation, seed);
    const InitResult result = solve(exact);
    EXPECT_EQ(result.status, InitStatus::kPureRotation)
        << "seed " << seed << ": " << result.message;
    EXPECT_FALSE(result.hasEstimate());
    EXPECT_LT((result.gyro_bias - exact.truth[0].gyro_bias).norm(), 1e-2);
  }
}

TEST_P(Degenerate, ConstantVelocityHasTooLittleExcitation) {
  expectStatus(Motion::kConstantVelocity, InitStatus::kTooLittleExcitation);
}

TEST_P(Degenerate, ExcitedMotionPassesTheSameGates) {
  expectStatus(Motion::kExcited, InitStatus::kSuccess);
}

TEST_P(Degenerate, PublishedMethodsHaveNoGatesOfTheirOwn) {
  // But for a scale that is not positive, which is no answer.
  for (GateMode mode : {GateMode::kOwn, GateMode::kOff}) {
    if (GetParam() == "slim" && mode == GateMode::kOwn) continue;  // slim has gates of its own
    int successes = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const InitResult result = solve(noisyWindow(Motion::kConstantVelocity, seed), mode);
      EXPECT_TRUE(result.hasEstimate());
      double scale = result.scale;  // of the alignment, in its own unit, where there is one
      for (const GateValue& gate : result.gates) {
        if (gate.name == GateName::kScalePositive) scale = gate.value;
      }
      if (scale > 1e-6) {
        EXPECT_EQ(result.status, InitStatus::kSuccess) << "seed " << seed;
        EXPECT_NE(result.message.find("not enforced"), std::string::npos) << result.message;
        ++successes;
      } else {
        EXPECT_EQ(result.status, InitStatus::kDegenerateAlignment) << "seed " << seed;
      }
    }
    EXPECT_GE(successes, 3);
  }
}

TEST_P(Degenerate, TooFewPointsIsTooFewTracks) {
  for (const int points : {0, 3, 7}) {
    for (const int lines : {0, 25}) {
      ExactWindowOptions options;
      options.points = points;
      options.lines = lines;
      options.parallel_lines_only = true;
      const InitResult result = solve(makeExactWindow(options), GateMode::kOff);
      EXPECT_EQ(result.status, InitStatus::kTooFewTracks) << points << ": " << result.message;
      EXPECT_FALSE(result.hasEstimate());
      if (points == 0) {
        EXPECT_FALSE(result.gyro_bias.allFinite());
      }
    }
  }
}

TEST_P(Degenerate, ThreeKeyframesAreTooFew) {
  for (int keyframes : {2, 3}) {
    ExactWindowOptions options;
    options.keyframes = keyframes;
    const InitResult result = solve(makeExactWindow(options), GateMode::kOff);
    EXPECT_EQ(result.status, InitStatus::kTooFewKeyframes) << result.message;
    EXPECT_NE(result.message.find("(minimum 4)"), std::string::npos) << result.message;
  }
}

TEST_P(Degenerate, ANonPositiveScaleIsNeverASuccess) {
  // At rest and without gates the sign of the scale is that of the noise.
  int positive = 0, others = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const InitResult result = solve(noisyWindow(Motion::kHover, seed), GateMode::kOff);
    if (result.scale > 0.0) {
      ++positive;
    } else {
      ++others;
      EXPECT_EQ(result.status, InitStatus::kDegenerateAlignment)
          << "seed " << seed << ": " << result.message;
    }
  }
  // A linear alignment has no say in the sign; the others take the length of a trajectory.
  if (GetParam() == "drt-l" || GetParam() == "slim-paper") {
    EXPECT_GE(positive, 10);
    EXPECT_GE(others, 10);
  } else {
    EXPECT_EQ(others, 0);
  }
}

TEST_P(Degenerate, ParallelBearingsAndCoincidentPointsDoNotCrash) {
  const InitResult result = solve(*windowOfParallelBearings());
  EXPECT_NE(result.status, InitStatus::kSuccess) << result.message;
}

INSTANTIATE_TEST_SUITE_P(Methods, Degenerate,
                         ::testing::ValuesIn(baselines::namesOf(baselines::methods())),
                         methodTestName);

}  // namespace
}  // namespace slim_init
