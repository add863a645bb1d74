// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Solves in a thread of their own, so that the host's thread does not wait for them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "slim_init/result.h"

namespace slim_init::vins_adapter {

/// What a solve is for.
enum class SolvePurpose { kSeed, kRecover, kCheck };

/// A finished solve.
struct Solved {
  double stamp = kNotComputed;  ///< the newest frame when it was posted [s], camera clock
  InitResult result;
  double solve_ms = 0.0;  ///< wall-clock time of the solve itself
};

/// Runs one solve at a time. A solve that is posted while another one runs begins after it; of
/// several that wait only the newest does. post(), take() and discard() belong to one thread. The
/// destructor waits for the solve that runs.
class SolveWorker {
 public:
  using Clock = std::chrono::steady_clock;
  using Solve = std::function<InitResult()>;

  SolveWorker() = default;
  ~SolveWorker();
  SolveWorker(const SolveWorker&) = delete;
  SolveWorker& operator=(const SolveWorker&) = delete;

  /// Posts a solve of the data up to `stamp`; false, and nothing is posted, if the system has no
  /// thread to give.
  bool post(SolvePurpose purpose, double stamp, Solve solve);

  /// The newest finished solve of `purpose`, once; waits until `deadline` as long as one of
  /// `purpose` runs or is to begin. Nothing: none has finished.
  std::optional<Solved> take(SolvePurpose purpose, Clock::time_point deadline);

  /// A solve of this purpose runs or is to begin.
  bool isBusy(SolvePurpose purpose) const;
  /// No solve runs or is to begin.
  bool isIdle() const;

  /// Forgets what has been posted; the result of the solve that runs is dropped.
  void discard();

 private:
  struct Posted {
    SolvePurpose purpose = SolvePurpose::kSeed;
    double stamp = kNotComputed;
    Solve solve;
  };

  void run();
  bool isBusyLocked(SolvePurpose purpose) const;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Posted> next_;
  std::optional<SolvePurpose> running_;
  std::map<SolvePurpose, Solved> finished_;  // one must not push out another that is wanted more
  bool keep_ = true;                         // the result of the solve that runs
  bool stop_ = false;
  std::thread thread_;
};

/// Runs a solve in the calling thread and measures it.
Solved solveNow(double stamp, const SolveWorker::Solve& solve);

}  // namespace slim_init::vins_adapter
