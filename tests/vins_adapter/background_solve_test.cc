// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Solves that take longer than the host waits: the host's thread goes on, and a later frame gets
// the answer. The initializer is a fake that takes 250 ms.
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/SVD>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "slim_init/initializer.h"
#include "slim_init/vins_adapter/host_adapter.h"
#include "slim_init/vins_adapter/host_convention.h"
#include "support/exact_window.h"
#include "support/text_parts.h"
#include "vins_adapter/host_streams.h"
#include "vins_adapter/oracle.h"

namespace slim_init::vins_adapter {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kFrames = 60;
constexpr std::chrono::milliseconds kFrameTime(100);

class BackgroundSolve : public FedAdapter {
 protected:
  BackgroundSolve() {
    exact_ = makeExactWindow(atTenHertz(kFrames));
    options_.watchdog = true;
    makeSlow(10.0);
  }
  void makeSlow(double max_wait_ms, int solve_ms = 250) {
    options_.max_wait_ms = max_wait_ms;
    auto slow = std::make_unique<Oracle>(exact_);
    slow->then = [solve_ms](const Priors&, InitResult*) {
      std::this_thread::sleep_for(std::chrono::milliseconds(solve_ms));
    };
    make(std::move(slow));
  }
  HostState stateOf(int k) const { return toHostState(exact_.truth[k], 0.0); }
  HostResult timed(const std::function<HostResult()>& call) {
    const auto begin = Clock::now();
    HostResult answer = call();
    waits_.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    return answer;
  }
  // The median: a machine that is busy stops any thread for a while.
  double medianWait() {
    std::nth_element(waits_.begin(), waits_.begin() + waits_.size() / 2, waits_.end());
    return waits_[waits_.size() / 2];
  }

  std::vector<double> waits_;
};

// At real time: a frame every 0.1 s. The states are those of the frame that gets the answer.
TEST_F(BackgroundSolve, ALaterFrameGetsTheStart) {
  feed(0, 19);
  int pending = 0;
  HostResult answer;
  int k = 20;
  for (auto next = Clock::now(); k < 40; ++k) {
    feed(k, k);
    answer = timed([&] { return adapter_->seed(stamps(k)); });
    if (!answer.pending) break;
    EXPECT_EQ(answer.result.status, InitStatus::kTimeLimit);
    EXPECT_EQ(answer.message, "the solve has not finished");
    ++pending;
    std::this_thread::sleep_until(next += kFrameTime);
  }
  ASSERT_TRUE(answer.success()) << answer.message;
  EXPECT_GE(pending, 2) << "250 ms are more than two frames";
  EXPECT_LE(pending, 8);
  EXPECT_LT(medianWait(), 60.0) << "the host waits for 10 ms";
  EXPECT_GE(answer.solve_ms, 250.0);
  for (int i = 1; i < kHostFrames; ++i) {
    const HostState& state = answer.window.states[i];
    const NavState& truth = exact_.truth[k - kHostFrames + 1 + i];
    EXPECT_EQ(state.stamp, exact_.keyframes[k - kHostFrames + 1 + i].t);
    EXPECT_NEAR(state.V.norm(), truth.v_w_b.norm(), 0.05) << i;
  }
}

// An answer is as old as the solve took: on a slow machine none would ever be used.
TEST_F(BackgroundSolve, OnlyAnAnswerThatHasWaitedIsTooOld) {
  for (const int solve_ms : {700, 100}) {
    makeSlow(10.0, solve_ms);
    feed(0, 20);
    EXPECT_TRUE(adapter_->seed(stamps(20)).pending);
    std::this_thread::sleep_for(std::chrono::milliseconds(solve_ms + 300));
    feed(21, 29);
    EXPECT_EQ(adapter_->seed(stamps(29)).success(), solve_ms == 700);
  }
}

TEST_F(BackgroundSolve, ARecoveryIsBridgedUntilItIsSolved) {
  feed(0, 30);
  const std::vector<HostState> healthy = statesOf(15, 26);
  HostResult answer = timed([&] { return adapter_->recover(stamps(30), healthy); });
  ASSERT_TRUE(answer.pending) << answer.message;
  // Four frames on by the IMU.
  const HostResult bridge = adapter_->bridge(stamps(30), healthy);
  ASSERT_TRUE(bridge.success()) << bridge.message;
  for (int i = 0; i < kHostFrames; ++i) {
    EXPECT_LT((bridge.window.states[i].P - exact_.truth[20 + i].p_w_b).norm(), 0.01) << i;
    EXPECT_LT((bridge.window.states[i].V - exact_.truth[20 + i].v_w_b).norm(), 0.01) << i;
  }
  EXPECT_FALSE(bridge.window.prior.empty());
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  feed(31, 31);
  answer = timed([&] { return adapter_->recover(stamps(31), healthy); });
  ASSERT_FALSE(answer.pending);
  ASSERT_TRUE(answer.success()) << answer.message;
  EXPECT_LT((answer.window.states.back().P - exact_.truth[31].p_w_b).norm(), 0.05);
  EXPECT_TRUE(answer.frame.ok);
  EXPECT_LT(answer.frame.position_sigma, 0.5);
  EXPECT_LT(*std::max_element(waits_.begin(), waits_.end()), 240.0);
}

// What is propagated is known less well than what the host has had.
TEST_F(BackgroundSolve, TheFirstStateOfABridgeIsWorthWhatTheImuHasLeft) {
  feed(0, kFrames - 1);
  const auto information = [&](int last_healthy) {
    const HostResult bridge =
        adapter_->bridge(stamps(kFrames - 1), statesOf(last_healthy, last_healthy));
    EXPECT_TRUE(bridge.success()) << bridge.message;
    const std::vector<double>& prior = bridge.window.prior;
    constexpr int kColumns = HostWindow::kPriorColumns;
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, kColumns, Eigen::RowMajor>> root(
        prior.data(), static_cast<Eigen::Index>(prior.size()) / kColumns, kColumns);
    // Velocity and tilt are seen together: the direction that is known least.
    const Eigen::MatrixXd velocity_and_biases = root.rightCols<9>();
    return velocity_and_biases.jacobiSvd().singularValues()(8);
  };
  const int first = kFrames - kHostFrames;
  EXPECT_NEAR(information(first), information(first - 1), 0.2 * information(first));
  EXPECT_LT(information(first - 30), 0.7 * information(first));
}

TEST_F(BackgroundSolve, WhatCannotBeBridgedIsDeclined) {
  feed(0, 30);
  EXPECT_FALSE(adapter_->bridge(stamps(30), {}).success());
  const HostResult late = adapter_->bridge(stamps(30), {stateOf(25)});
  EXPECT_FALSE(late.success());
  EXPECT_EQ(late.message, "a frame of the host's window is older than its healthy states");
  HostState old = stateOf(0);
  old.stamp -= 30.0;
  expectParts(adapter_->bridge(stamps(30), {old}).message, "do not cover");
}

// The watchdog goes on with what it has; the answer counts with the frame at which it is there.
TEST_F(BackgroundSolve, TheWatchdogDoesNotWait) {
  feed(0, 30);
  const auto begin = Clock::now();
  HostHealth health = watch(window(30));
  EXPECT_LT(std::chrono::duration<double>(Clock::now() - begin).count(), 0.2);
  EXPECT_TRUE(health.healthy);
  EXPECT_TRUE(std::isnan(health.confirmed_stamp));
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  feed(31, 31);
  health = watch(window(31));
  EXPECT_EQ(health.confirmed_stamp, exact_.keyframes[30].t);
}

// A window that knows the tilt to 3 deg has nothing against a host that is 6 deg from it; it does
// not call it right either.
TEST_F(BackgroundSolve, WhatIsOnlyWithinTheSigmaIsNotConfirmed) {
  for (const double angle : {0.0, 0.105}) {
    options_.max_wait_ms = -1.0;
    auto unsure = std::make_unique<Oracle>(exact_);
    unsure->then = [&](const Priors&, InitResult* result) {
      GateValue tilt;
      tilt.name = GateName::kTiltSigma;
      tilt.value = 3.0;
      result->gates.push_back(tilt);
      const Eigen::AngleAxisd turn(angle, Eigen::Vector3d::UnitX());
      for (NavState& state : result->states) {
        // The velocity in the body is the same.
        state.R_w_b = turn * state.R_w_b;
        state.v_w_b = turn * state.v_w_b;
      }
    };
    make(std::move(unsure));
    feed(0, 30);
    const HostHealth health = watch(window(30), true);
    EXPECT_TRUE(health.healthy) << health.reason;
    EXPECT_EQ(std::isnan(health.confirmed_stamp), angle > 0.0);
  }
}

TEST_F(BackgroundSolve, ARestartOfTheStreamsForgetsTheSolveThatRuns) {
  feed(0, 30);
  ASSERT_TRUE(adapter_->seed(stamps(30)).pending);
  next_ = 0;
  feed(0, 30);
  ASSERT_EQ(adapter_->info().counts.restarts(), 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  EXPECT_TRUE(adapter_->seed(stamps(30)).pending);
}

// Lock step: whatever a solve takes, the call returns its answer.
TEST_F(BackgroundSolve, ANegativeWaitIsSynchronous) {
  makeSlow(-1.0);
  feed(0, 30);
  const HostResult answer = adapter_->seed(stamps(30));
  EXPECT_FALSE(answer.pending);
  EXPECT_TRUE(answer.success()) << answer.message;
  EXPECT_GE(answer.solve_ms, 100.0);
}

// Streams, solves of `slim` and the watchdog from three threads, with restarts in between.
TEST_F(BackgroundSolve, StreamsGoOnWhileSolvesRun) {
  make(makeInitializer(exact_.calibration, InitializerOptions()));
  std::atomic<bool> stop{false};
  std::thread lines([&] {
    while (!stop) {
      adapter_->addLines(exact_.keyframes[5].t, {});
      adapter_->info();
      adapter_->setTd(0.0);
    }
  });
  for (int round = 0; round < 5; ++round) {
    for (int k = 0; k < 30; ++k) {
      feed(k, k);
      if (k < kHostFrames) continue;
      adapter_->seed(stamps(k));
      watch(window(k), true);
      adapter_->recover(stamps(k), {stateOf(k - 5)});
    }
    next_ = 0;  // and the streams begin anew
  }
  stop = true;
  lines.join();
}

double residentBytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0.0, resident = 0.0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

// 10,000 recoveries, each solved in the other thread, in no time.
TEST_F(BackgroundSolve, TenThousandRecoveriesDoNotGrow) {
  options_.watchdog = false;
  options_.max_wait_ms = 1000.0;
  make(std::make_unique<Oracle>(exact_));
  feed(0, 30);
  const std::vector<HostState> healthy = statesOf(15, 26);
  double before = 0.0;
  for (int i = 0; i < 10000; ++i) {
    // Another frame each time: the wait is per frame.
    ASSERT_TRUE(adapter_->recover(stamps(30 - i % 2), healthy).success()) << i;
    if (i == 1000) before = residentBytes();
  }
  ASSERT_GT(before, 0.0);
  EXPECT_LT(residentBytes() - before, 2e6);
}

}  // namespace
}  // namespace slim_init::vins_adapter
