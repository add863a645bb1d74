// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What must not change the answer.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "slim_init/baselines/baselines.h"
#include "support/exact_window.h"
#include "support/method_name.h"
#include "support/same_result.h"

namespace slim_init {
namespace {

class Invariance : public ::testing::TestWithParam<std::string> {
 protected:
  InitResult solve(const InitWindow& window,
                   const InitializerOptions& options = InitializerOptions()) const {
    return baselines::makeMethod(GetParam(), options)->solve(window);
  }
};

TEST_P(Invariance, RenamedTracksMatterOnlyByRounding) {
  const ExactWindow exact = noisyWindow();
  std::vector<FrameObservation> frames = exact.keyframes;
  for (FrameObservation& frame : frames) {
    for (PointObservation& point : frame.points) point.id = 1000000 - 7 * point.id;
  }
  const InitResult a = solve(*exact.window), b = solve(*windowOf(exact, frames));
  // slim sums over more and larger numbers before it stops at a third of a sigma.
  const double relative = GetParam() == "slim" ? 1e-6 : 1e-8;
  EXPECT_NEAR(a.scale, b.scale, relative);
  EXPECT_LT((a.gyro_bias - b.gyro_bias).norm(), 0.1 * relative);
}

TEST_P(Invariance, YawAndOriginOfTheWorldDoNotMatter) {
  // The same motion and scene, turned and moved: the sensors see no difference.
  ExactWindowOptions moved;
  moved.yaw_rad = -2.1;
  moved.origin = Eigen::Vector3d(100, -50, 7);
  const InitResult a = solve(*makeExactWindow(ExactWindowOptions()).window);
  const InitResult b = solve(*makeExactWindow(moved).window);
  ASSERT_EQ(a.states.size(), b.states.size());
  EXPECT_NEAR(a.scale, b.scale, 1e-7);
  EXPECT_LT((a.gravity_b0 - b.gravity_b0).norm(), 1e-7);
  for (std::size_t k = 0; k < a.states.size(); ++k) {
    EXPECT_LT((a.states[k].p_w_b - b.states[k].p_w_b).norm(), 1e-7);
    EXPECT_LT((a.states[k].R_w_b - b.states[k].R_w_b).norm(), 1e-7);
  }
}

TEST_P(Invariance, StartOfTimeDoesNotMatter) {
  const ExactWindow exact = noisyWindow();
  std::vector<FrameObservation> frames = exact.keyframes;
  std::vector<ImuSample> imu = exact.imu;
  for (FrameObservation& frame : frames) frame.t += 1024.0;
  for (ImuSample& sample : imu) sample.t += 1024.0;
  const auto window = madeWindow(exact.calibration, frames, imu);
  const InitResult a = solve(*exact.window), b = solve(*window);
  EXPECT_NEAR(a.scale, b.scale, 1e-6);
  EXPECT_LT((a.gyro_bias - b.gyro_bias).norm(), 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Methods, Invariance,
                         ::testing::ValuesIn(baselines::namesOf(baselines::methods())),
                         methodTestName);

// Eight threads, each with all methods and windows in an order of its own: equal input gives equal
// bytes, whatever a solver has solved before and solves meanwhile.
TEST(Threads, MethodsAtOnceGiveWhatEachGivesAlone) {
  struct Task {
    const WindowSolver* solver;
    std::shared_ptr<const InitWindow> window;
    InitResult alone;
  };
  std::vector<std::unique_ptr<WindowSolver>> solvers;
  std::vector<Task> tasks;
  for (const std::string& name : baselines::namesOf(baselines::methods())) {
    solvers.push_back(baselines::makeMethod(name, InitializerOptions()));
    for (const unsigned seed : {1u, 2u, 3u}) {
      const std::shared_ptr<const InitWindow> window = noisyWindow(seeded(seed)).window;
      const auto fresh = baselines::makeMethod(name, InitializerOptions());
      tasks.push_back({solvers.back().get(), window, fresh->solve(*window)});
    }
  }
  constexpr std::size_t kThreads = 8;
  std::vector<std::vector<InitResult>> results(kThreads, std::vector<InitResult>(tasks.size()));
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < kThreads; ++i) {
    threads.emplace_back([&tasks, &results, i] {
      for (std::size_t k = 0; k < tasks.size(); ++k) {
        const std::size_t task = (k + i * tasks.size() / kThreads) % tasks.size();
        results[i][task] = tasks[task].solver->solve(*tasks[task].window);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<InitResult>& of_thread : results) {
    for (std::size_t k = 0; k < tasks.size(); ++k) {
      EXPECT_TRUE(sameBytes(tasks[k].alone, of_thread[k])) << tasks[k].solver->name();
    }
  }
}

TEST(SlimPaperSwitches, WithoutLinesTheLineTermsChangeNothing) {
  ExactWindowOptions options;
  options.lines = 0;
  const ExactWindow exact = noisyWindow(options);
  baselines::BaselineOptions off;
  off.slim_paper.use_vp = off.slim_paper.use_line_epipolar = off.slim_paper.use_line_normal = false;
  const InitResult with =
      baselines::makeMethod("slim-paper", InitializerOptions())->solve(*exact.window);
  const InitResult without =
      baselines::makeMethod("slim-paper", InitializerOptions(), off)->solve(*exact.window);
  EXPECT_TRUE(sameBytes(with, without));
}

TEST(SlimPaperSwitches, EachTermChangesTheAnswerByItself) {
  ExactWindowOptions scene;
  scene.pixel_noise = 0.3;
  scene.parallel_lines_only = true;
  const ExactWindow exact = makeExactWindow(scene);
  baselines::BaselineOptions none;
  none.slim_paper.use_vp = none.slim_paper.use_line_epipolar = none.slim_paper.use_line_normal =
      false;
  const InitResult base =
      baselines::makeMethod("slim-paper", InitializerOptions(), none)->solve(*exact.window);
  baselines::BaselineOptions vp = none, epipolar = none, normal = none;
  vp.slim_paper.use_vp = true;
  epipolar.slim_paper.use_line_epipolar = true;
  normal.slim_paper.use_line_normal = true;
  const InitResult with_vp =
      baselines::makeMethod("slim-paper", InitializerOptions(), vp)->solve(*exact.window);
  EXPECT_NE(with_vp.gyro_bias, base.gyro_bias);
  for (const baselines::BaselineOptions& options : {epipolar, normal}) {
    const InitResult with =
        baselines::makeMethod("slim-paper", InitializerOptions(), options)->solve(*exact.window);
    EXPECT_EQ(with.gyro_bias, base.gyro_bias);  // step 1 does not see the lines
    EXPECT_NE(with.scale, base.scale);
  }
}

}  // namespace
}  // namespace slim_init
