// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace slim_init::evaluation {

/// Runs tasks on threads and finishes them in the order in which they were added. All calls from
/// one thread.
class OrderedTasks {
 public:
  /// With one thread, or where the system gives none, tasks run inside add().
  explicit OrderedTasks(int threads);
  /// Waits for the tasks that run; those that wait for a thread are dropped with their `finish`.
  ~OrderedTasks();
  OrderedTasks(const OrderedTasks&) = delete;
  OrderedTasks& operator=(const OrderedTasks&) = delete;

  /// Queues `work` for some thread; null: there is nothing to do. `finish` is called after it on
  /// the thread of the caller, by this or a later add() or by finishAll(), and after the `finish`
  /// of every task added before. Waits where twice as many tasks as threads are unfinished, so that
  /// what they hold stays bounded.
  void add(std::function<void()> work, std::function<void()> finish);

  /// Waits for every task and finishes it.
  void finishAll();

 private:
  struct Task {
    std::function<void()> work, finish;
    bool done = false;
  };

  void runWorker();
  /// Finishes tasks from the oldest on, until fewer than `unfinished` are left and the oldest of
  /// them is not done.
  void finishDown(std::size_t unfinished);

  std::mutex mutex_;
  std::condition_variable work_added_, work_done_;
  std::deque<Task> tasks_;  ///< unfinished, oldest first; references stay valid at both ends
  std::size_t next_ = 0;    ///< of tasks_: the first that no thread has taken
  bool stopping_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace slim_init::evaluation
