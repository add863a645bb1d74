// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A body that stands and then moves: stationary while it stands, a start with the first motion that
// joins the rest, and nothing of it for a body that has not stood.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "geometry/so3.h"
#include "slim_init/initializer.h"
#include "support/exact_window.h"
#include "support/fake_solver.h"
#include "support/fed_initializer.h"
#include "support/gaussian.h"
#include "support/same_result.h"

namespace slim_init {
namespace {

// Of ExactWindowOptions [s].
const double kRestBefore = ExactWindowOptions().rest_s;

ExactWindow streams(Motion motion, unsigned seed) {
  ExactWindowOptions options = drawnFromTheModel(seed, 0.05);
  options.motion = motion;
  options.keyframes = 61;
  options.interval_s = 0.05;
  options.points = 300;  // a third of them in view at a time
  options.lines = 0;
  return makeExactWindow(options);
}

// The velocity of the body at every image, 0.02 m/s and 5 % of it.
void feedVelocity(const ExactWindow& exact, std::size_t k, double factor, unsigned seed,
                  IInitializer* initializer) {
  Gaussian gaussian(100 * seed + static_cast<unsigned>(k));
  const NavState& truth = exact.truth[k];
  SpeedSample sample;
  sample.t = truth.t;
  sample.velocity = factor * truth.R_w_b.transpose() * truth.v_w_b;
  const double sigma = 0.02 + 0.05 * sample.velocity.norm();
  sample.velocity += sigma * gaussian.vector();
  sample.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  EXPECT_EQ(initializer->addSpeed(sample), AddStatus::kAdded);
}

struct Start {
  std::unique_ptr<IInitializer> initializer;
  std::vector<InitResult> results;  // one per image, up to the first success
  std::size_t frames = 0;

  const InitResult& last() const { return results.back(); }
};

// Fed and solved at every image from `first` on until there is a success.
// With `factor` above zero a wheel measures that times the velocity.
Start solveAtEveryImage(const ExactWindow& exact, const InitializerOptions& options,
                        std::size_t first = 0, double factor = 0.0, unsigned seed = 1) {
  Start out;
  std::string error;
  Calibration calibration = exact.calibration;
  calibration.speed_sensor.calibrated = factor > 0.0;
  out.initializer = makeInitializer(calibration, options, &error);
  EXPECT_NE(out.initializer, nullptr) << error;
  auto sample = exact.imu.begin();
  for (std::size_t k = 0; k < exact.keyframes.size(); ++k) {
    for (; sample != exact.imu.end() && sample->t < exact.keyframes[k].t + 0.02; ++sample) {
      if (sample->t > exact.keyframes[first].t - 0.1) out.initializer->addImu(*sample);
    }
    if (k < first) continue;
    if (factor > 0.0) feedVelocity(exact, k, factor, seed, out.initializer.get());
    out.initializer->addFrame(exact.keyframes[k]);
    out.results.push_back(out.initializer->initialize());
    out.frames = k + 1;
    if (out.last().success()) break;
  }
  return out;
}

InitializerOptions withoutRest() {
  InitializerOptions options;
  options.slim.start_from_rest = false;
  return options;
}

TEST(FromRest, StationaryWithGravityAndBiasWhileItStands) {
  const ExactWindow exact = streams(Motion::kFromRest, 1);
  const Start start = solveAtEveryImage(exact, InitializerOptions());
  int stationary = 0;
  for (std::size_t k = 0; k < start.results.size(); ++k) {
    const InitResult& result = start.results[k];
    if (exact.truth[k].t > kRestBefore || result.status != InitStatus::kStationary) continue;
    ++stationary;
    EXPECT_EQ(result.validate(), "");
    EXPECT_FALSE(result.hasEstimate());
    EXPECT_LT(gravityErrorRad(result.gravity_b0, exact.truth[0]), 1.0 * M_PI / 180.0);
    EXPECT_LT((result.gyro_bias - exact.truth[0].gyro_bias).norm(), 2e-3);
  }
  // From 1 s on.
  EXPECT_GE(stationary, 9);
}

TEST(FromRest, TheFirstMotionStartsItAndJoinsTheRest) {
  double with = 0.0, without = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const ExactWindow exact = streams(Motion::kFromRest, seed);
    const Start start = solveAtEveryImage(exact, InitializerOptions());
    const InitResult& result = start.last();
    ASSERT_TRUE(result.success()) << "seed " << seed << ": " << result.message;
    with += result.states.back().t / 20;
    EXPECT_TRUE(std::isfinite(result.at_rest_since)) << result.message;
    EXPECT_LT(result.at_rest_since, 0.2);
    const NavState& truth = exact.truth[start.frames - 1];
    const NavState& newest = result.states.back();
    EXPECT_NEAR(newest.t, truth.t, 0.005);
    const Eigen::Vector3d true_v = truth.R_w_b.transpose() * truth.v_w_b;
    EXPECT_LT((newest.R_w_b.transpose() * newest.v_w_b - true_v).norm(),
              0.05 + 0.1 * true_v.norm());
    // Origin where it stood, and the turn since then.
    const NavState& first = result.states.front();
    EXPECT_LT(first.p_w_b.norm(), 0.01);
    const Eigen::Matrix3d turn = exact.truth[0].R_w_b.transpose() * truth.R_w_b;
    EXPECT_LT(logSO3((first.R_w_b.transpose() * newest.R_w_b).transpose() * turn).norm(), 0.01);
    EXPECT_NEAR((newest.p_w_b - first.p_w_b).norm(), (truth.p_w_b - exact.truth[0].p_w_b).norm(),
                0.01 + 0.1 * (truth.p_w_b - exact.truth[0].p_w_b).norm());
    const Start plain = solveAtEveryImage(exact, withoutRest());
    without +=
        plain.last().states.empty() ? exact.truth.back().t / 20 : plain.last().states.back().t / 20;
  }
  std::cout << "mean time of the start: " << with << " s, without the rest " << without << " s\n";
  EXPECT_LT(with, without);
  EXPECT_LT(with, kRestBefore + 0.4);
}

// Way from the first keyframe to the last; of an estimate that is accepted.
void expectPath(const ExactWindow& exact, const InitResult& result, unsigned seed) {
  if (!result.success()) return;
  const auto truthAt = [&exact](double t) {
    return exact.truth[std::lround((t - exact.truth.front().t) / 0.05)];
  };
  const NavState &first = result.states.front(), &last = result.states.back();
  const double path = (truthAt(last.t).p_w_b - truthAt(first.t).p_w_b).norm();
  EXPECT_NEAR((last.p_w_b - first.p_w_b).norm(), path, 0.005 + 0.25 * path) << "seed " << seed;
}

// In the first moments speeds and paths are hardly more than noise: the wheel must neither make the
// start from rest impossible nor its scale seem certain.
TEST(FromRest, SpeedsGiveAScaleThatIsRight) {
  for (const double factor : {1.0, 1.2}) {
    int from_rest = 0;
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const ExactWindow exact = streams(Motion::kFromRest, seed);
      const Start start = solveAtEveryImage(exact, InitializerOptions(), 0, factor, seed);
      const InitResult& result = start.last();
      ASSERT_TRUE(result.success()) << "seed " << seed << ": " << result.message;
      from_rest += std::isfinite(result.at_rest_since);
      expectPath(exact, result, seed);
      expectPath(exact, solveAtEveryImage(exact, withoutRest(), 0, factor, seed).last(), seed);
    }
    EXPECT_GE(from_rest, factor == 1.0 ? 6 : 4);
  }
}

TEST(FromRest, StatesBeforeTheFirstKeyframeAreThoseOfTheRest) {
  const ExactWindow exact = streams(Motion::kFromRest, 3);
  const Start start = solveAtEveryImage(exact, InitializerOptions());
  ASSERT_TRUE(start.last().success());
  const InitResult& result = start.last();
  std::vector<NavState> states;
  std::string error;
  const std::vector<double> times = {result.at_rest_since, 0.5, result.states.back().t};
  ASSERT_TRUE(start.initializer->statesAt(result, times, 0.01, &states, &error)) << error;
  EXPECT_EQ(states[0].p_w_b, result.states.front().p_w_b);
  EXPECT_EQ(states[1].v_w_b.norm(), 0.0);
  EXPECT_EQ(states[1].t, 0.5);
  // Not before the rest was seen.
  EXPECT_FALSE(
      start.initializer->statesAt(result, {result.at_rest_since - 0.1}, 0.01, &states, &error));
}

TEST(FromRest, AMotionWithoutARestIsSolvedAsBefore) {
  for (const Motion motion : {Motion::kExcited, Motion::kConstantVelocity, Motion::kPureRotation}) {
    const ExactWindow exact = streams(motion, 1);
    const Start with = solveAtEveryImage(exact, InitializerOptions());
    const Start without = solveAtEveryImage(exact, withoutRest());
    ASSERT_EQ(with.results.size(), without.results.size());
    for (std::size_t k = 0; k < with.results.size(); ++k) {
      EXPECT_TRUE(sameBytes(with.results[k], without.results[k]));
    }
  }
  // Nor is one that stands for less than 1 s of what the initializer has received.
  const ExactWindow exact = streams(Motion::kFromRest, 1);
  const auto late = static_cast<std::size_t>((kRestBefore - 0.3) / 0.05);
  for (const InitResult& result : solveAtEveryImage(exact, InitializerOptions(), late).results) {
    EXPECT_TRUE(std::isnan(result.at_rest_since));
  }
}

// Only a method that takes a prior gains by the rest; the others are solved as they were.
TEST(FromRest, AMethodWithoutPriorsIsSolvedAtRestToo) {
  const ExactWindow exact = streams(Motion::kFromRest, 1);
  std::string error;
  const auto initializer = makeInitializer(std::make_unique<FakeSolver>("other"), exact.calibration,
                                           InitializerOptions(), &error);
  ASSERT_NE(initializer, nullptr) << error;
  for (const ImuSample& sample : exact.imu) initializer->addImu(sample);
  for (int k = 0; k < 28; ++k) initializer->addFrame(exact.keyframes[k]);
  EXPECT_EQ(initializer->initialize().message, InitResult().message);
}

// The rig is off by 3 deg and 10 ms; the start says so, or waits.
TEST(FromRest, AMiscalibratedRigIsFoundAsInAStartWithoutARest) {
  int accepted = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ExactWindow exact = streams(Motion::kFromRest, seed);
    exact.calibration.R_b_c *= expSO3(Eigen::Vector3d(0.04, -0.03, 0.02));
    for (FrameObservation& frame : exact.keyframes) frame.t -= 0.01;
    const Start start = solveAtEveryImage(exact, InitializerOptions());
    if (!start.last().success()) continue;
    ++accepted;
    const NavState& newest = start.last().states.back();
    const NavState& truth = exact.truth[start.frames - 1];
    EXPECT_LT(
        (newest.R_w_b.transpose() * newest.v_w_b - truth.R_w_b.transpose() * truth.v_w_b).norm(),
        0.1 + 0.15 * truth.v_w_b.norm())
        << "seed " << seed;
  }
  EXPECT_GE(accepted, 8);
}

TEST(FromRest, ASlowCreepIsContradictedAndNotStartedFrom) {
  // The body "stands" while the samples say that it has accelerated to 0.5 m/s in one of them: the
  // velocity of the prior is wrong.
  ExactWindow exact = streams(Motion::kFromRest, 2);
  for (ImuSample& sample : exact.imu) {
    if (std::abs(sample.t - kRestBefore - 0.005) < 0.0026) sample.accel.z() += 100.0;
  }
  for (const InitResult& result : solveAtEveryImage(exact, InitializerOptions()).results) {
    EXPECT_FALSE(result.success() && std::isfinite(result.at_rest_since)) << result.message;
  }
}

}  // namespace
}  // namespace slim_init
