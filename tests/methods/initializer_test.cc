// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The interface of the host: streaming, recovery into the old odometry frame, states at other
// times.
#include "slim_init/initializer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

#include "geometry/so3.h"
#include "slim_init/baselines/baselines.h"
#include "support/exact_window.h"
#include "support/fake_solver.h"
#include "support/fed_initializer.h"

namespace slim_init {
namespace {

using Eigen::Vector3d;

InitializerOptions tenKeyframes() {
  InitializerOptions options;
  options.window.keyframes = options.window.min_keyframes = 10;
  options.window.min_interval_s = 0.22;
  options.window.max_span_s = 0.0;
  return options;
}

class InitializerTest : public ::testing::Test {
 protected:
  std::unique_ptr<IInitializer> make() const {
    std::string error;
    auto initializer =
        baselines::makeInitializer("drt-l", exact_.calibration, tenKeyframes(), &error);
    EXPECT_NE(initializer, nullptr) << error;
    return initializer;
  }
  const ExactWindow exact_ = makeExactWindow(ExactWindowOptions());
};

TEST_F(InitializerTest, WaitsThenAnswersLikeTheSolver) {
  const auto initializer = make();
  EXPECT_EQ(initializer->initialize().status, InitStatus::kTooFewKeyframes);
  feed(*initializer, exact_);
  const InitResult streamed = initializer->initialize();
  ASSERT_TRUE(streamed.success()) << streamed.message;
  const InitResult direct =
      baselines::makeMethod("drt-l", InitializerOptions())->solve(*exact_.window);
  ASSERT_EQ(streamed.states.size(), direct.states.size());
  EXPECT_EQ(streamed.scale, direct.scale);
  EXPECT_EQ(streamed.states[7].p_w_b, direct.states[7].p_w_b);
  EXPECT_EQ(initializer->info().method, "drt-l");
  initializer->reset();
  EXPECT_EQ(initializer->initialize().status, InitStatus::kTooFewKeyframes);
}

TEST_F(InitializerTest, HandsOutWhatAHostNeedsToKnow) {
  const auto initializer = make();
  EXPECT_TRUE(std::isnan(initializer->info().imu.first));
  EXPECT_EQ(initializer->info().window_span_s, tenKeyframes().window.fullSpan());
  feed(*initializer, exact_);
  EXPECT_EQ(initializer->info().imu.first, exact_.imu.front().t);
  EXPECT_EQ(initializer->info().imu.last, exact_.imu.back().t);
  EXPECT_EQ(initializer->info().counts.frames.added(), 10);
  EXPECT_EQ(initializer->info().calibration.td, exact_.calibration.td);
  initializer->setTd(0.01);
  EXPECT_EQ(initializer->info().calibration.td, 0.01);
  EXPECT_EQ(initializer->addLines(exact_.keyframes.back().t + 0.1, {}), AddStatus::kWaiting);
  initializer->reset();
  EXPECT_EQ(initializer->info().counts.frames.added(), 0);
  EXPECT_EQ(initializer->info().counts.lines[AddStatus::kWaiting], 0);
}

TEST_F(InitializerTest, ASuccessThatContradictsItselfIsNotPassedOn) {
  const auto initializer =
      makeInitializer(std::make_unique<FakeSolver>("other",
                                                   [](const InitWindow& /*window*/) {
                                                     InitResult bare;
                                                     bare.status = InitStatus::kSuccess;
                                                     return bare;
                                                   }),
                      exact_.calibration, InitializerOptions());
  ASSERT_NE(initializer, nullptr);
  feed(*initializer, exact_);
  const InitResult result = initializer->initialize();
  EXPECT_EQ(result.status, InitStatus::kNumericalFailure);
  EXPECT_EQ(result.message, "other reported success without states");
}

// The window is keyframes 4..13; the host failed at keyframe 2, 0.5 s before it.
TEST_F(InitializerTest, RecoverCarriesAStateFromBeforeTheWindowByTheImuButNotAcrossAGap) {
  ExactWindowOptions longer;
  longer.keyframes = 14;
  const ExactWindow exact = makeExactWindow(longer);
  const auto recoverWithGap = [&](double gap_s) {
    ExactWindow with_gap = exact;
    with_gap.imu = withGap(exact.imu, 0.6, 0.6 + gap_s);
    auto initializer = baselines::makeInitializer("drt-l", exact.calibration, tenKeyframes());
    feed(*initializer, with_gap);
    return initializer->initialize({{healthyPrior(exact.truth[2])}, {}});
  };
  const InitResult result = recoverWithGap(0.0);
  ASSERT_TRUE(result.success()) << result.message;
  ASSERT_EQ(result.states.size(), 10u);
  for (std::size_t k = 0; k < 10; ++k) {
    EXPECT_LT((result.states[k].p_w_b - exact.truth[k + 4].p_w_b).norm(), 1e-5);
    EXPECT_LT(logSO3(result.states[k].R_w_b.transpose() * exact.truth[k + 4].R_w_b).norm(), 1e-6);
  }
  EXPECT_TRUE(recoverWithGap(0.03).success());
  const InitResult refused = recoverWithGap(0.2);
  EXPECT_EQ(refused.status, InitStatus::kInvalidInput);
  EXPECT_NE(refused.message.find("window 0.2"), std::string::npos) << refused.message;
}

TEST_F(InitializerTest, RecoverTakesGravityFromTheNewSolution) {
  const auto initializer = make();
  feed(*initializer, exact_);
  NavState tilted = exact_.truth[3];
  tilted.R_w_b = expSO3(Vector3d(0.1, -0.05, 0.0)) * tilted.R_w_b;  // the host's tilt was off
  const InitResult result = initializer->initialize({{healthyPrior(tilted)}, {}});
  ASSERT_TRUE(result.success()) << result.message;
  const Vector3d down_b = result.states[0].R_w_b.transpose() * Vector3d(0, 0, -1);
  EXPECT_LT(gravityErrorRad(down_b, exact_.truth[0]), 1e-6);
}

// A window that grows, `rate_` images a second.
class AskedAgain : public ::testing::Test {
 protected:
  // `scale` may change from window to window.
  void start(const std::function<double(const InitWindow&)>& scale) {
    auto solver = std::make_unique<FakeSolver>("fake", [scale](const InitWindow& window) {
      return bentPath(window.times(), scale(window), 0.05);
    });
    solver_ = solver.get();
    initializer_ = makeInitializer(std::move(solver), Calibration(), InitializerOptions());
    ASSERT_NE(initializer_, nullptr);
  }
  // Data up to the image k, the first one after a start or restart at image `first`.
  void feedTo(int k) {
    for (; image_ <= k; ++image_) {
      for (int i = 0; i < 200 / rate_; ++i) {
        ImuSample sample;
        sample.t = (image_ - 1.0) / rate_ + 0.005 * (i + 1);
        sample.accel = Vector3d(0.0, 0.0, 9.81);
        initializer_->addImu(sample);
      }
      FrameObservation frame;
      frame.t = 1.0 * image_ / rate_ - 0.006;
      initializer_->addFrame(frame);
    }
  }
  InitResult askAt(int k) {
    feedTo(k);
    return initializer_->initialize();
  }
  static double right(const InitWindow& /*window*/) { return 1.0; }

  FakeSolver* solver_ = nullptr;
  std::unique_ptr<IInitializer> initializer_;
  int image_ = 1, rate_ = 10;
};

TEST_F(AskedAgain, AtEveryImageItSolvesOnceAndAcceptsTheThirdThatAgrees) {
  start(right);
  EXPECT_EQ(askAt(4).status, InitStatus::kTooFewKeyframes);
  EXPECT_EQ(solver_->windows.size(), 0);
  // The first question has no answers before it: shorter windows, of which one is long enough.
  EXPECT_FALSE(askAt(5).success());
  const std::size_t first = solver_->windows.size();
  EXPECT_EQ(first, 2);
  EXPECT_TRUE(askAt(6).success());
  EXPECT_EQ(solver_->windows.size(), first + 1);
  EXPECT_TRUE(askAt(7).success());
  EXPECT_EQ(solver_->windows.size(), first + 2);
}

TEST_F(AskedAgain, AnAnswerThatMovesIsRefusedUntilTwoAgreeWithIt) {
  start([](const InitWindow& window) { return window.times().back() < 0.75 ? 2.0 : 1.0; });
  EXPECT_FALSE(askAt(5).success());
  EXPECT_TRUE(askAt(6).success());  // wrong, and three answers agree: it cannot know
  const InitResult moved = askAt(8);
  EXPECT_EQ(moved.status, InitStatus::kScaleTooUncertain) << moved.message;
  EXPECT_FALSE(askAt(9).success());
  EXPECT_TRUE(askAt(10).success());
}

TEST_F(AskedAgain, NowAndThenItSolvesShorterWindowsAsWell) {
  start(right);
  EXPECT_TRUE(askAt(12).success());
  EXPECT_EQ(solver_->windows.size(), 3);
  EXPECT_TRUE(askAt(16).success()) << "0.4 s later";
  EXPECT_EQ(solver_->windows.size(), 6);
  EXPECT_TRUE(askAt(18).success()) << "0.2 s later";
  EXPECT_EQ(solver_->windows.size(), 7);
}

TEST_F(AskedAgain, ASlowCameraStartsWithTheThirdAnswer) {
  rate_ = 3;
  start(right);
  EXPECT_FALSE(askAt(5).success());
  EXPECT_TRUE(askAt(6).success());
}

TEST_F(AskedAgain, AFullWindowIsAcceptedAlone) {
  start(right);
  EXPECT_TRUE(askAt(40).success());
  EXPECT_EQ(solver_->windows.size(), 1);
}

// Asked often enough, a scene that is far away is accepted by chance.
TEST_F(AskedAgain, AFullWindowAfterARefusalIsComparedWithShorterOnes) {
  start([](const InitWindow& window) { return window.times().back() < 4.35 ? 2.0 : 1.0; });
  EXPECT_FALSE(askAt(5).success());
  const std::size_t first = solver_->windows.size();
  const InitResult moved = askAt(44);
  EXPECT_EQ(moved.status, InitStatus::kScaleTooUncertain) << moved.message;
  EXPECT_EQ(solver_->windows.size(), first + 3);
}

TEST_F(AskedAgain, NothingIsRememberedAcrossAResetOrAChangeOfTd) {
  for (const double td : {0.0005, 0.002}) {
    image_ = 1;
    start(right);
    EXPECT_TRUE(askAt(12).success());
    initializer_->setTd(td);
    EXPECT_TRUE(askAt(13).success());
    EXPECT_EQ(solver_->windows.size(), td > 1e-3 ? 6 : 4);
  }
  initializer_->reset();
  image_ = 1;
  EXPECT_FALSE(askAt(5).success());
}

TEST(MakeInitializer, RefusesBadArgumentsWithAMessage) {
  std::string error;
  Calibration bad;
  bad.focal_px = 0.0;
  EXPECT_EQ(baselines::makeInitializer("drt-l", bad, InitializerOptions(), &error), nullptr);
  EXPECT_EQ(error, "calibration: focal_px is 0, must be in [10, 100000]");
  EXPECT_EQ(baselines::makeInitializer("nothing", Calibration(), InitializerOptions(), &error),
            nullptr);
  EXPECT_NE(error.find("unknown method"), std::string::npos);
  InitializerOptions options;
  options.imu.max_accel = 16.0;
  EXPECT_EQ(makeInitializer(Calibration(), options, &error), nullptr);
  EXPECT_EQ(error, "imu.max_accel is 16, must be in [19.6, inf]");
  EXPECT_EQ(makeInitializer(nullptr, Calibration(), InitializerOptions(), &error), nullptr);
  EXPECT_EQ(error, "the solver is null");
}

}  // namespace
}  // namespace slim_init
