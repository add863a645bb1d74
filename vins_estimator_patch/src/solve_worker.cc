// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "solve_worker.h"

#include <system_error>
#include <utility>

namespace slim_init::vins_adapter {

Solved solveNow(double stamp, const SolveWorker::Solve& solve) {
  Solved solved;
  solved.stamp = stamp;
  const auto begin = SolveWorker::Clock::now();
  solved.result = solve();
  solved.solve_ms =
      std::chrono::duration<double, std::milli>(SolveWorker::Clock::now() - begin).count();
  return solved;
}

SolveWorker::~SolveWorker() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
    next_.reset();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool SolveWorker::post(SolvePurpose purpose, double stamp, Solve solve) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!thread_.joinable()) {
    try {
      thread_ = std::thread([this] { run(); });
    } catch (const std::system_error&) {
      return false;
    }
  }
  next_ = Posted{purpose, stamp, std::move(solve)};
  changed_.notify_all();
  return true;
}

std::optional<Solved> SolveWorker::take(SolvePurpose purpose, Clock::time_point deadline) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait_until(lock, deadline, [&] { return !isBusyLocked(purpose); });
  auto finished = finished_.extract(purpose);
  if (finished.empty()) return std::nullopt;
  return std::move(finished.mapped());
}

bool SolveWorker::isBusyLocked(SolvePurpose purpose) const {
  return running_ == purpose || (next_.has_value() && next_->purpose == purpose);
}

bool SolveWorker::isBusy(SolvePurpose purpose) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return isBusyLocked(purpose);
}

bool SolveWorker::isIdle() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !running_ && !next_;
}

void SolveWorker::discard() {
  const std::lock_guard<std::mutex> lock(mutex_);
  next_.reset();
  finished_.clear();
  keep_ = false;
}

void SolveWorker::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || next_.has_value(); });
    if (stop_) return;
    const Posted posted = std::move(*next_);
    next_.reset();
    running_ = posted.purpose;
    keep_ = true;
    lock.unlock();
    Solved solved = solveNow(posted.stamp, posted.solve);
    lock.lock();
    running_.reset();
    if (keep_) finished_[posted.purpose] = std::move(solved);
    changed_.notify_all();
  }
}

}  // namespace slim_init::vins_adapter
