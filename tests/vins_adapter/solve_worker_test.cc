// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "solve_worker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <optional>
#include <thread>

namespace slim_init::vins_adapter {
namespace {

using Clock = SolveWorker::Clock;
using std::chrono::milliseconds;

SolveWorker::Solve quick(double scale) {
  return [scale] {
    InitResult result;
    result.scale = scale;
    return result;
  };
}

// A solve that ends when it is let go.
class HeldSolve {
 public:
  SolveWorker::Solve solve(double scale) {
    return [this, scale] {
      begun_.set_value();
      released_.wait();
      return quick(scale)();
    };
  }
  void waitUntilBegun() { begun_.get_future().wait(); }
  void release() { release_.set_value(); }

 private:
  std::promise<void> begun_, release_;
  std::shared_future<void> released_{release_.get_future().share()};
};

Clock::time_point soon() { return Clock::now() + milliseconds(5); }
Clock::time_point late() { return Clock::now() + std::chrono::seconds(60); }

TEST(SolveWorker, ASolveThatEndsInTimeIsTakenOnce) {
  SolveWorker worker;
  EXPECT_FALSE(worker.take(SolvePurpose::kSeed, late()).has_value()) << "nothing to wait for";
  ASSERT_TRUE(worker.post(SolvePurpose::kSeed, 3.5, quick(2.0)));
  const std::optional<Solved> solved = worker.take(SolvePurpose::kSeed, late());
  ASSERT_TRUE(solved.has_value());
  EXPECT_EQ(solved->result.scale, 2.0);
  EXPECT_EQ(solved->stamp, 3.5);
  EXPECT_GE(solved->solve_ms, 0.0);
  EXPECT_FALSE(worker.take(SolvePurpose::kSeed, soon()).has_value());
}

TEST(SolveWorker, NobodyWaitsBeyondTheDeadline) {
  SolveWorker worker;
  HeldSolve held;
  ASSERT_TRUE(worker.post(SolvePurpose::kSeed, 0.0, held.solve(1.0)));
  held.waitUntilBegun();
  EXPECT_TRUE(worker.isBusy(SolvePurpose::kSeed));
  EXPECT_FALSE(worker.isBusy(SolvePurpose::kRecover));
  EXPECT_FALSE(worker.take(SolvePurpose::kSeed, soon()).has_value());
  // Nor for a solve of another purpose.
  EXPECT_FALSE(worker.take(SolvePurpose::kRecover, late()).has_value());
  held.release();
  ASSERT_TRUE(worker.take(SolvePurpose::kSeed, late()).has_value());
}

TEST(SolveWorker, AFinishedSolveWaitsWhileAnotherPurposeIsServed) {
  SolveWorker worker;
  HeldSolve recovery;
  ASSERT_TRUE(worker.post(SolvePurpose::kRecover, 1.0, recovery.solve(1.0)));
  recovery.waitUntilBegun();
  ASSERT_TRUE(worker.post(SolvePurpose::kCheck, 2.0, quick(2.0)));
  recovery.release();
  EXPECT_EQ(worker.take(SolvePurpose::kCheck, late())->stamp, 2.0);
  EXPECT_EQ(worker.take(SolvePurpose::kRecover, soon())->stamp, 1.0);
}

TEST(SolveWorker, OfThoseThatWaitTheNewestWins) {
  SolveWorker worker;
  HeldSolve held;
  std::atomic<int> replaced{0};
  ASSERT_TRUE(worker.post(SolvePurpose::kCheck, 0.0, held.solve(1.0)));
  held.waitUntilBegun();
  worker.post(SolvePurpose::kRecover, 1.0, [&replaced] {
    ++replaced;
    return InitResult();
  });
  worker.post(SolvePurpose::kRecover, 2.0, quick(7.0));
  held.release();
  const std::optional<Solved> solved = worker.take(SolvePurpose::kRecover, late());
  ASSERT_TRUE(solved.has_value());
  EXPECT_EQ(solved->result.scale, 7.0);
  EXPECT_EQ(replaced, 0);
}

TEST(SolveWorker, WhatIsDiscardedIsNotTaken) {
  SolveWorker worker;
  HeldSolve held;
  ASSERT_TRUE(worker.post(SolvePurpose::kSeed, 0.0, held.solve(1.0)));
  held.waitUntilBegun();
  worker.discard();
  worker.post(SolvePurpose::kSeed, 1.0, quick(4.0));
  held.release();
  const std::optional<Solved> solved = worker.take(SolvePurpose::kSeed, late());
  ASSERT_TRUE(solved.has_value());
  EXPECT_EQ(solved->result.scale, 4.0);
}

TEST(SolveWorker, EndsWhileASolveRuns) {
  HeldSolve held;
  std::thread later;
  {
    SolveWorker worker;
    ASSERT_TRUE(worker.post(SolvePurpose::kSeed, 0.0, held.solve(1.0)));
    held.waitUntilBegun();
    worker.post(SolvePurpose::kSeed, 1.0, [] {
      ADD_FAILURE() << "a solve that waits is not begun any more";
      return InitResult();
    });
    later = std::thread([&held] {
      std::this_thread::sleep_for(milliseconds(20));
      held.release();
    });
  }
  later.join();
}

}  // namespace
}  // namespace slim_init::vins_adapter
