// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The estimator by itself: what a good seed becomes, what a wrong one, and what is dropped.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "backend/simulated_sequence.h"
#include "geometry/so3.h"
#include "slim_init/backend/downstream.h"
#include "slim_init/backend/sliding_window_estimator.h"
#include "slim_init/evaluation/metrics.h"
#include "support/text_parts.h"

namespace slim_init::backend {
namespace {

using evaluation::Sequence;

// Ten seconds of excited motion from the true states: 100 points at 0.6 px, EuRoC's IMU.
constexpr double kSeconds = 5.0;  // after the seed [s]
constexpr double kAte = 0.05;     // [m]
constexpr double kScaleError = 0.02;

Sequence sequenceOf(const std::string& motion, unsigned seed, double duration_s) {
  return makeSimulatedSequence({motion, duration_s, seed});
}

/// The true states of ten frames, two images apart, as an initializer would give them.
InitResult trueAnswer(const Sequence& sequence) {
  InitResult answer;
  answer.status = InitStatus::kSuccess;
  for (std::size_t k = 0; k < 10; ++k) answer.states.push_back(truthOfFrame(sequence, 10 + 2 * k));
  return answer;
}

class Estimator : public ::testing::TestWithParam<std::string> {};

TEST_P(Estimator, KeepsTheScaleForTenSeconds) {
  for (const unsigned seed : {1u, 2u}) {
    const Sequence sequence = sequenceOf(GetParam(), seed, 14.0);
    const auto record = runDownstream(sequence, sequence.calibration, trueAnswer(sequence), 10.0);
    ASSERT_TRUE(record.ran) << record.message;
    EXPECT_FALSE(record.diverged) << record.message;
    EXPECT_NEAR(record.seconds, 10.0, 0.11);
    EXPECT_LT(record.ate, kAte) << "seed " << seed;
    EXPECT_LT(record.scale_error, kScaleError) << "seed " << seed;
  }
}

// A tenth of the tracks slides off: the loss has to hold them.
TEST_P(Estimator, HoldsOutliers) {
  const Sequence sequence = makeSimulatedSequence({GetParam(), 9.0, 1, 0.1});
  const auto record = runDownstream(sequence, sequence.calibration, trueAnswer(sequence), kSeconds);
  ASSERT_TRUE(record.ran) << record.message;
  EXPECT_FALSE(record.diverged) << record.message;
  EXPECT_LT(record.ate, kAte);
}

// Ever more wrong: gravity turned by a right angle, which excited motion may repair; a velocity of
// 40 m/s that is not there; both, upside down, which nothing repairs.
TEST_P(Estimator, WrongSeedsAreNoticed) {
  const Sequence sequence = sequenceOf(GetParam(), 1, 9.0);
  const auto wrongAnswer = [&](double tilt, double speed) {
    InitResult answer = trueAnswer(sequence);
    const Eigen::Matrix3d R = expSO3(Eigen::Vector3d(tilt, 0, 0));
    const double t0 = answer.states.front().t;
    for (NavState& state : answer.states) {
      state.R_w_b = R * state.R_w_b;
      state.p_w_b = R * state.p_w_b + Eigen::Vector3d(speed * (state.t - t0), 0, 0);
      state.v_w_b = R * state.v_w_b + Eigen::Vector3d(speed, 0, 0);
    }
    return answer;
  };
  for (const auto& [tilt, speed] : {std::make_pair(M_PI / 2, 0.0), std::make_pair(0.0, 40.0)}) {
    const auto record =
        runDownstream(sequence, sequence.calibration, wrongAnswer(tilt, speed), kSeconds);
    ASSERT_TRUE(record.ran) << record.message;
    EXPECT_TRUE(record.diverged || record.scale_error < 0.25)
        << "quietly wrong: tilt " << tilt << ", speed " << speed << ", ate " << record.ate;
  }
  const auto record =
      runDownstream(sequence, sequence.calibration, wrongAnswer(M_PI, 40.0), kSeconds);
  ASSERT_TRUE(record.ran) << record.message;
  EXPECT_TRUE(record.diverged) << "ate " << record.ate << ", scale error " << record.scale_error;
  EXPECT_FALSE(record.message.empty());
}

INSTANTIATE_TEST_SUITE_P(Motions, Estimator, ::testing::Values("figure-eight", "circle"),
                         [](const auto& param) {
                           return param.param == "circle" ? std::string("Circle")
                                                          : std::string("FigureEight");
                         });

TEST(EstimatorInput, DropsWhatCannotBe) {
  const Sequence sequence = sequenceOf("circle", 1, 3.0);
  const auto made = SlidingWindowEstimator::make(sequence.calibration);
  SlidingWindowEstimator& estimator = *made;
  EXPECT_FALSE(estimator.addFrame(sequence.frames[3]).ok());  // no IMU yet
  for (const ImuSample& sample : sequence.imu) {
    estimator.addImu(sample);
    ImuSample broken = sample;
    broken.gyro.x() = 1e6;
    estimator.addImu(broken);  // again
    broken.t += 0.001;
    broken.gyro.x() = std::numeric_limits<double>::quiet_NaN();
    estimator.addImu(broken);
  }
  EXPECT_TRUE(estimator.addFrame(sequence.frames[4]).ok());
  EXPECT_TRUE(estimator.addFrame(sequence.frames[5]).ok());
  const FrameReport again = estimator.addFrame(sequence.frames[5]);
  expectParts(again.problem, "is not after the last");

  const FrameReport report = estimator.seed({truthOfFrame(sequence, 4)});
  expectParts(report.problem, "1 states for a window of 2 frames");
  EXPECT_FALSE(estimator.seeded());
  EXPECT_TRUE(estimator.states().empty());
  ASSERT_TRUE(estimator.seed({truthOfFrame(sequence, 4), truthOfFrame(sequence, 5)}).ok());
  EXPECT_LT((estimator.newest().p_w_b - truthOfFrame(sequence, 5).p_w_b).norm(), 0.05);
}

// Damaged samples in the window, replaced before a start: as if they had never come.
TEST(EstimatorInput, ReplacesSamples) {
  const Sequence sequence = sequenceOf("circle", 1, 3.0);
  const auto newest = [&sequence](bool damaged, bool replaced) {
    const auto made = SlidingWindowEstimator::make(sequence.calibration);
    SlidingWindowEstimator& estimator = *made;
    std::vector<ImuSample> right;
    for (ImuSample sample : sequence.imu) {
      if (sample.t > 0.92 && sample.t < 0.96) {
        right.push_back(sample);
        if (damaged) sample.accel.x() += 400.0;
      }
      estimator.addImu(sample);
    }
    std::vector<NavState> truth;
    for (std::size_t k = 4; k < 14; ++k) {
      EXPECT_TRUE(estimator.addFrame(sequence.frames[k]).ok());
      truth.push_back(truthOfFrame(sequence, k));
    }
    estimator.replaceImu({});  // nothing
    if (replaced) estimator.replaceImu(right);
    estimator.seed(truth);
    return Eigen::Vector3d(estimator.newest().v_w_b);
  };
  EXPECT_EQ(newest(true, true), newest(false, false));
  EXPECT_NE(newest(true, false), newest(false, false));
}

TEST(EstimatorInput, TheWindowIsBounded) {
  const Sequence sequence = sequenceOf("hover", 1, 6.0);
  const auto made = SlidingWindowEstimator::make(sequence.calibration);
  SlidingWindowEstimator& estimator = *made;
  for (const ImuSample& sample : sequence.imu) estimator.addImu(sample);
  for (std::size_t k = 5; k < sequence.frames.size() - 1; ++k) {
    estimator.addFrame(sequence.frames[k]);
    EXPECT_LE(estimator.stamps().size(), 10u);
    // Standing still, the frames between are dropped, but nothing older than a start needs.
    EXPECT_LE(estimator.stamps().back() - estimator.stamps().front(), 2.3);
  }
}

TEST(EstimatorInput, EqualInputGivesEqualStates) {
  const Sequence sequence = sequenceOf("circle", 2, 6.0);
  const auto first = runDownstream(sequence, sequence.calibration, trueAnswer(sequence), 2.0);
  const auto second = runDownstream(sequence, sequence.calibration, trueAnswer(sequence), 2.0);
  EXPECT_EQ(first.ate, second.ate);
  EXPECT_EQ(first.scale_error, second.scale_error);
}

TEST(FailureDetection, NamesRuleValueAndBound) {
  NavState before, after;
  before.t = 0.0;
  after.t = 0.1;
  FrameReport report;
  EXPECT_EQ(detectFailure(before, after, report), "");
  after.accel_bias.x() = 3.0;
  EXPECT_EQ(detectFailure(before, after, report), "accelerometer bias 3 m/s^2 (limit 2.5)");
  after = before;
  after.gyro_bias.y() = -1.5;
  EXPECT_EQ(detectFailure(before, after, report), "gyroscope bias 1.5 rad/s (limit 1)");
  after = before;
  after.p_w_b.z() = -1.5;
  EXPECT_EQ(detectFailure(before, after, report),
            "vertical step between two frames 1.5 m (limit 1)");
  after.p_w_b.x() = 6.0;
  expectParts(detectFailure(before, after, report), "step between two frames 6.18");
  after = before;
  after.p_w_b.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(detectFailure(before, after, report), "");
  after = before;
  report.newest_views = 40;
  report.newest_inliers = 19;
  EXPECT_EQ(detectFailure(before, after, report),
            "19 of 40 points are where they are expected (minimum fraction 0.5)");
  report.newest_views = 9;
  report.newest_inliers = 0;
  EXPECT_EQ(detectFailure(before, after, report), "");
}

}  // namespace
}  // namespace slim_init::backend
