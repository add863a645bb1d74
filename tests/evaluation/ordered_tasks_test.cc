// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "ordered_tasks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <numeric>

namespace slim_init::evaluation {
namespace {

void sleepMs(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

TEST(OrderedTasks, FinishesInOrderWhateverTheTasksTake) {
  for (const int threads : {1, 2, 4, 9}) {
    std::vector<int> worked(40, 0), finished;
    const std::thread::id caller = std::this_thread::get_id();
    OrderedTasks tasks(threads);
    for (int i = 0; i < 40; ++i) {
      tasks.add(
          [&worked, i] {
            sleepMs((7 * i) % 5);
            worked[static_cast<std::size_t>(i)] = i + 1;
          },
          [&, i] {
            EXPECT_EQ(std::this_thread::get_id(), caller);
            EXPECT_EQ(worked[static_cast<std::size_t>(i)], i + 1);
            finished.push_back(i);
          });
    }
    tasks.finishAll();
    std::vector<int> in_order(40);
    std::iota(in_order.begin(), in_order.end(), 0);
    EXPECT_EQ(finished, in_order) << threads;
  }
}

TEST(OrderedTasks, RunsAsManyAtOnceAsItHasThreads) {
  constexpr int kThreads = 3;
  std::atomic<int> inside{0};
  std::atomic<int> together{0};
  OrderedTasks tasks(kThreads);
  for (int i = 0; i < kThreads; ++i) {
    // Every task waits for the others: one after the other they would meet nobody.
    tasks.add(
        [&] {
          ++inside;
          for (int ms = 0; ms < 10000 && inside < kThreads; ++ms) sleepMs(1);
          if (inside >= kThreads) ++together;
        },
        [] {});
  }
  tasks.finishAll();
  EXPECT_EQ(together, kThreads);
}

TEST(OrderedTasks, HoldsBackWhoeverAddsTooMany) {
  constexpr int kThreads = 2;
  int added = 0, finished = 0, most = 0;
  OrderedTasks tasks(kThreads);
  for (int i = 0; i < 50; ++i) {
    ++added;
    // The first one is slow: all the others would pile up behind it.
    tasks.add([i] { sleepMs(i == 0 ? 50 : 0); }, [&] { ++finished; });
    most = std::max(most, added - finished);
  }
  tasks.finishAll();
  EXPECT_EQ(finished, 50);
  EXPECT_LT(most, 2 * kThreads);
}

TEST(OrderedTasks, TasksWithoutWorkKeepTheirPlace) {
  std::vector<int> finished;
  OrderedTasks tasks(2);
  tasks.add([] { sleepMs(20); }, [&] { finished.push_back(0); });
  tasks.add(nullptr, [&] { finished.push_back(1); });
  tasks.add([] {}, [&] { finished.push_back(2); });
  tasks.finishAll();
  EXPECT_EQ(finished, (std::vector<int>{0, 1, 2}));
}

TEST(OrderedTasks, WaitsAtTheEndForWhatStillRuns) {
  std::atomic<int> running{0};
  {
    OrderedTasks tasks(2);
    for (int i = 0; i < 3; ++i) {
      tasks.add(
          [&] {
            ++running;
            sleepMs(20);
            --running;
          },
          [] {});
    }
  }
  EXPECT_EQ(running, 0);
}

}  // namespace
}  // namespace slim_init::evaluation
