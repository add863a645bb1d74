// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// An initializer that receives data while it solves.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <iostream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "slim_init/initializer.h"
#include "slim_init/keyframe_window.h"
#include "support/data_sheet_options.h"
#include "support/exact_window.h"
#include "support/same_result.h"

namespace slim_init {
namespace {

/// A solver that stops in the middle of a solve until it is released.
class Held : public WindowSolver {
 public:
  explicit Held(std::unique_ptr<WindowSolver> inner) : inner_(std::move(inner)) {}
  const std::string& name() const override { return inner_->name(); }
  bool usesPriors() const override { return true; }
  InitResult solveWindow(const InitWindow& window, const SolveRequest& request,
                         WorkBudget* budget) const override {
    if (request.first_state) return inner_->solve(window, request, budget);
    std::unique_lock<std::mutex> lock(mutex_);
    if (hold_) {
      held_ = true;
      changed_.notify_all();
      changed_.wait(lock, [this] { return !hold_; });
    }
    lock.unlock();
    ++solves;
    return inner_->solve(window, request, nullptr);
  }
  void hold() {
    const std::lock_guard<std::mutex> lock(mutex_);
    hold_ = true;
    held_ = false;
  }
  void waitUntilHeld() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return held_; });
  }
  void release() {
    const std::lock_guard<std::mutex> lock(mutex_);
    hold_ = false;
    changed_.notify_all();
  }
  mutable std::atomic<int> solves{0};

 private:
  std::unique_ptr<WindowSolver> inner_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  bool hold_ = false;
  mutable bool held_ = false;
};

class DuringASolve : public ::testing::Test {
 protected:
  DuringASolve() {
    const InitializerOptions options = dataSheetOptions();
    auto solver = std::make_unique<Held>(makeSlimSolver(options));
    solver_ = solver.get();
    initializer_ = makeInitializer(std::move(solver), exact_.calibration, options);
  }
  // Samples and frames up to keyframe `k`.
  void feedTo(int k, IInitializer* initializer) const {
    const double t = exact_.keyframes[k].t;
    for (const ImuSample& sample : exact_.imu) {
      const TimeSpan have = initializer->info().imu;
      if (!(sample.t <= have.last) && sample.t <= t + 0.01) initializer->addImu(sample);
    }
    for (const FrameObservation& frame : exact_.keyframes) {
      if (frame.t <= t + 1e-9 && frame.t > fed_) initializer->addFrame(frame);
    }
  }
  void feedTo(int k) {
    feedTo(k, initializer_.get());
    fed_ = exact_.keyframes[k].t;
  }

  const ExactWindow exact_ = makeExactWindow(drawnStream(3, Motion::kExcited, 20));
  Held* solver_ = nullptr;
  std::unique_ptr<IInitializer> initializer_;
  double fed_ = -1e9;
};

TEST_F(DuringASolve, DataAreAddedWithoutWaitingAndWithoutEffectOnIt) {
  feedTo(12);
  const InitResult expected = initializer_->initialize();
  solver_->hold();
  InitResult during;
  std::thread worker([&] { during = initializer_->initialize(); });
  solver_->waitUntilHeld();
  // Every call that the contract allows, while the solve has not ended.
  feedTo(19);
  initializer_->addLines(exact_.keyframes[5].t, {});
  initializer_->setTd(exact_.calibration.td + 1e-4);
  EXPECT_EQ(initializer_->info().counts.frames.added(), 20);
  EXPECT_EQ(initializer_->info().calibration.td, exact_.calibration.td + 1e-4);
  EXPECT_GT(initializer_->info().imu.last, exact_.keyframes[18].t);
  std::vector<NavState> states;
  EXPECT_TRUE(initializer_->statesAt(expected, {expected.states.back().t}, 0.1, &states, nullptr));
  solver_->release();
  worker.join();
  EXPECT_TRUE(sameBytes(during, expected));
  EXPECT_GT(initializer_->initialize().states.back().t, expected.states.back().t);
}

TEST_F(DuringASolve, WhatIsForgottenMeanwhileIsNotRemembered) {
  feedTo(12);
  solver_->hold();
  InitResult during;
  std::thread worker([&] { during = initializer_->initialize(); });
  solver_->waitUntilHeld();
  initializer_->reset();
  fed_ = -1e9;
  feedTo(12);
  solver_->release();
  worker.join();
  EXPECT_TRUE(during.success()) << "of the data that it began with: " << during.message;
  // The memory would save the solves of the windows before; a fresh initializer needs them.
  const int before = solver_->solves;
  const InitResult again = initializer_->initialize();
  EXPECT_EQ(solver_->solves - before, 3);
  EXPECT_TRUE(sameBytes(again, during));
}

// For the thread sanitizer: all at once, without any order.
TEST_F(DuringASolve, StreamsAndSolvesRunAtTheSameTime) {
  std::atomic<bool> done{false};
  std::thread adding([&] {
    for (int round = 0; round < 3; ++round) {
      for (int k = 0; k < 20; ++k) {
        feedTo(k);
        initializer_->addLines(exact_.keyframes[k].t, exact_.keyframes[k].lines);
        initializer_->setTd(exact_.calibration.td);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      initializer_->reset();
      fed_ = -1e9;
    }
    done = true;
  });
  StatePrior healthy;
  healthy.state = exact_.truth[8];
  healthy.covariance.setIdentity();
  int solved = 0;
  while (!done) {
    const InitResult result =
        ++solved % 2 == 0 ? initializer_->initialize() : initializer_->initialize({{healthy}, {}});
    std::vector<NavState> states;
    if (result.success()) {
      initializer_->statesAt(result, {result.states.back().t}, 0.1, &states, nullptr);
    }
    EXPECT_EQ(result.validate(), "");
  }
  adding.join();
  EXPECT_GT(solved, 0);
}

// Ten seconds of a 200 Hz IMU and of a 20 Hz camera.
TEST(KeyframeWindow, ASnapshotIsFast) {
  WindowOptions options;
  KeyframeWindow window(eurocCalibration(), options);
  for (int i = 0; i < 2000; ++i) {
    ImuSample sample;
    sample.t = 0.005 * i;
    sample.accel = Eigen::Vector3d(0.0, 0.0, 9.81);
    window.addImu(sample);
    if (i % 10 != 0) continue;
    FrameObservation frame;
    frame.t = sample.t;
    frame.points.resize(150);
    for (int p = 0; p < 150; ++p) {
      frame.points[p].id = p;
      frame.points[p].bearing = Eigen::Vector3d(0.001 * p, 0.0, 1.0).normalized();
    }
    window.addFrame(frame);
  }
  double best = 1e9;
  for (int i = 0; i < 20; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const KeyframeWindow snapshot = window;
    const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
    best = std::min(best, ms.count());
    EXPECT_EQ(snapshot.imu().size(), window.imu().size());
  }
  std::cout << "a snapshot took " << best << " ms\n";
#ifdef NDEBUG
  EXPECT_LT(best, 0.2);
#endif
}

}  // namespace
}  // namespace slim_init
