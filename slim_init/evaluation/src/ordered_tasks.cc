// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "ordered_tasks.h"

#include <system_error>
#include <utility>

namespace slim_init::evaluation {

OrderedTasks::OrderedTasks(int threads) {
  for (int i = 0; threads > 1 && i < threads; ++i) {
    try {
      workers_.emplace_back([this] { runWorker(); });
    } catch (const std::system_error&) {
      return;  // fewer threads take longer and find the same
    }
  }
}

OrderedTasks::~OrderedTasks() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  work_added_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void OrderedTasks::add(std::function<void()> work, std::function<void()> finish) {
  if (workers_.empty()) {
    if (work) work();
    finish();
    return;
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    tasks_.push_back({std::move(work), std::move(finish)});
  }
  work_added_.notify_one();
  finishDown(2 * workers_.size());
}

void OrderedTasks::finishAll() { finishDown(1); }

void OrderedTasks::runWorker() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    work_added_.wait(lock, [this] { return stopping_ || next_ < tasks_.size(); });
    if (stopping_) return;
    Task& task = tasks_[next_++];
    if (task.work) {
      lock.unlock();
      task.work();
      lock.lock();
    }
    task.done = true;
    work_done_.notify_one();
  }
}

void OrderedTasks::finishDown(std::size_t unfinished) {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!tasks_.empty()) {
    if (!tasks_.front().done) {
      if (tasks_.size() < unfinished) return;
      work_done_.wait(lock, [this] { return tasks_.front().done; });
    }
    const Task task = std::move(tasks_.front());
    tasks_.pop_front();
    --next_;
    lock.unlock();
    task.finish();
    lock.lock();
  }
}

}  // namespace slim_init::evaluation
