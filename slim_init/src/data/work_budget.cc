// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/work_budget.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "slim_init/text.h"

namespace slim_init {
namespace {

// The computation takes 400 units where a unit is a microsecond. A fifth of the time is for work
// that is not counted and for the error of this measurement [units]. The best of some runs has not
// been interrupted.
constexpr double kKernelWork = 0.8 * 400.0;
constexpr int kKernelRuns = 5;
constexpr int kKernelRounds = 770;

// What a linearisation does: products of small blocks, and a Cholesky factorisation.
double kernel() {
  using Matrix12 = Eigen::Matrix<double, 12, 12>;
  Eigen::Matrix<double, 6, 2> J = Eigen::Matrix<double, 6, 2>::Constant(0.1);
  Matrix12 H = Matrix12::Identity();
  double sum = 0.0;
  for (int i = 0; i < kKernelRounds; ++i) {
    J(i % 6, i % 2) += 1e-3;
    for (int k = 0; k < 4; ++k) {
      H.topLeftCorner<6, 6>().noalias() += J * J.transpose();
      H.bottomRightCorner<6, 6>().noalias() += J * J.transpose();
    }
    const Eigen::LLT<Matrix12> llt(H);
    sum += llt.matrixL()(11, 11);
  }
  return sum;
}

}  // namespace

double measuredWorkPerMs() {
  static const double kMeasured = [] {
    double best_ms = std::numeric_limits<double>::infinity();
    volatile double unused = 0.0;
    for (int run = 0; run < kKernelRuns; ++run) {
      const auto start = std::chrono::steady_clock::now();
      unused = unused + kernel();
      const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
      best_ms = std::min(best_ms, ms.count());
    }
    return kKernelWork / best_ms;
  }();
  return kMeasured;
}

WorkLimits liveLimits(WorkLimits limits) {
  if (limits.work_per_ms == 0.0) limits.work_per_ms = -1.0;
  return limits;
}

WorkBudget::WorkBudget(const WorkLimits& limits)
    : max_solve_ms_(limits.max_solve_ms), limit_(std::numeric_limits<double>::infinity()) {
  if (!(limits.max_solve_ms > 0.0)) return;
  // 0: that of a desktop processor, where a unit is about a microsecond.
  const double rate = limits.work_per_ms == 0.0 ? 1000.0 : limits.work_per_ms;
  limit_ = limits.max_solve_ms * (rate > 0.0 ? rate : measuredWorkPerMs());
}

bool WorkBudget::allows(const char* search) {
  if (isUsedUp()) leaveOut(search);
  return !isUsedUp();
}

void WorkBudget::leaveOut(const char* search) {
  if (left_out_.empty()) left_out_ = search;
}

std::string WorkBudget::takeLeftOut() {
  if (left_out_.empty()) return "";
  return text("the time limit of ", max_solve_ms_, " ms (limits.max_solve_ms) skipped ",
              std::exchange(left_out_, ""));
}

WorkBudget::Share::Share(double share, WorkBudget* budget, double reserve)
    : budget_(*budget), limit_(budget->limit_) {
  budget_.limit_ = budget_.used_ + share * std::max(0.0, limit_ - budget_.used_ - reserve);
}

}  // namespace slim_init
