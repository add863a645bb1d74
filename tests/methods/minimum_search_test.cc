// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <utility>

#include "pipeline/metric_estimate.h"
#include "support/exact_window.h"
#include "support/true_state.h"
#include "support/unlimited_budget.h"

namespace slim_init {
namespace {

// A window with what searchMinimum() needs, at the true state.
struct Search {
  explicit Search(ExactWindow window)
      : exact(std::move(window)),
        truth(trueState(exact)),
        pre(preintegrateInflated(*exact.window, truth.gyro_bias, truth.accel_bias,
                                 options.inertial)) {}

  RefinedWindow run(const WindowState& start, WorkBudget* budget, bool again = true) const {
    return searchMinimum({*exact.window, pre, options.refinement, options.inertial, *budget},
                         believedLines(*exact.window, start, options), start, again);
  }
  RefinedWindow run(const WindowState& start) const {
    WorkBudget budget = unlimitedBudget();
    return run(start, &budget);
  }

  // The noise of a vibrating IMU: the way from a mirrored start leads over costs that a quiet one
  // raises too high.
  static InitializerOptions vibrating() {
    InitializerOptions options;
    options.inertial.accel_noise_factor = 10.0;
    options.inertial.gyro_noise_factor = 3.0;
    return options;
  }

  InitializerOptions options = vibrating();
  ExactWindow exact;
  WindowState truth;
  std::vector<Preintegration> pre;
};

// Two lines that change places in the middle of the window.
ExactWindow withConfusedLines(int pairs) {
  ExactWindow exact = noisyWindow();
  std::vector<FeatureId> ids;
  for (const Track& track : exact.window->lineTracks()) {
    if (track.size() == exact.window->size()) ids.push_back(track.id);
  }
  EXPECT_GE(static_cast<int>(ids.size()), 2 * pairs);
  for (int k = exact.window->size() / 2; k < exact.window->size(); ++k) {
    for (LineObservation& line : exact.keyframes[k].lines) {
      for (int p = 0; p < pairs; ++p) {
        const FeatureId a = ids[p], b = ids[ids.size() - 1 - p];
        if (line.id == a || line.id == b) {
          line.id = line.id == a ? b : a;
          break;
        }
      }
    }
  }
  exact.window = windowOf(exact);
  return exact;
}

TEST(BelievedLines, ConfusedTracksAreCutWhereLinesArePruned) {
  Search search(withConfusedLines(3));
  EXPECT_GT(believedLines(*search.exact.window, search.truth, search.options).size(),
            search.exact.window->lineTracks().size())
      << "both halves of a confused track are one line each";
  search.options.slim.prune_lines = false;
  EXPECT_EQ(believedLines(*search.exact.window, search.truth, search.options).size(),
            search.exact.window->lineTracks().size());
  search.options.slim.prune_lines = true;
  search.options.refinement.use_lines = false;
  EXPECT_EQ(believedLines(*search.exact.window, search.truth, search.options).size(),
            search.exact.window->lineTracks().size());
}

TEST(BelievedLines, FewerAgreeWithAWrongStart) {
  Search search(noisyWindow());
  WindowState wrong = search.truth;
  for (int k = 1; k < wrong.size(); ++k) wrong.p_b0.col(k) += Eigen::Vector3d(0.3 * k, -0.2, 0.5);
  const auto observations = [&](const WindowState& start) {
    int count = 0;
    for (const Track& line : believedLines(*search.exact.window, start, search.options)) {
      count += line.size();
    }
    return count;
  };
  EXPECT_GT(observations(search.truth), observations(wrong));
}

// A limit in units of work.
WorkBudget budgetOf(double units) {
  WorkLimits limits;
  limits.max_solve_ms = 1.0;
  limits.work_per_ms = units;
  return WorkBudget(limits);
}

TEST(SearchMinimum, AMinimumWithALargeChiSquareIsSearchedAgain) {
  Search search(withSlidingPoints(noisyWindow(), 5));
  const auto workOf = [&search](double suspicious_chi2) {
    search.options.refinement.suspicious_chi2 = suspicious_chi2;
    WorkBudget budget = unlimitedBudget();
    EXPECT_TRUE(search.run(search.truth, &budget).valid);
    return budget.used();
  };
  EXPECT_GT(workOf(1e-9), 1.3 * workOf(1e6));
}

// A mirrored start needs the second search; with the work of the first one it is left out, and said
// so. Equal work gives equal results, to the last bit.
TEST(SearchMinimum, TheLimitLeavesOutTheSecondSearch) {
  Search search(withSlidingPoints(noisyWindow(), 5));
  WindowState wrong = search.truth;
  wrong.p_b0 = -wrong.p_b0;
  wrong.v_b0 = -wrong.v_b0;
  WorkBudget all = unlimitedBudget();
  const RefinedWindow found = search.run(wrong, &all);
  ASSERT_TRUE(found.valid);
  EXPECT_EQ(all.takeLeftOut(), "");
  WorkBudget first = unlimitedBudget();
  const RefinedWindow once = search.run(wrong, &first, false);
  ASSERT_LT(found.cost, 0.9 * once.cost) << "this window needs the second search";
  EXPECT_LT(found.cost, 1.01 * search.run(search.truth).cost);

  WorkBudget enough = budgetOf(1.01 * all.used() + first.used());
  EXPECT_EQ(search.run(wrong, &enough).cost, found.cost);
  EXPECT_EQ(enough.takeLeftOut(), "");

  WorkBudget little = budgetOf(1.001 * first.used());
  const RefinedWindow limited = search.run(wrong, &little);
  EXPECT_EQ(limited.cost, once.cost) << "the first minimum";
  EXPECT_EQ(little.takeLeftOut().find("the time limit of 1 ms (limits.max_solve_ms) skipped "), 0u);
  EXPECT_EQ(little.takeLeftOut(), "") << "said once";
  EXPECT_LT(little.used(), 1.3 * first.used());

  for (const double share : {0.2, 0.5, 0.9}) {
    WorkBudget a = budgetOf(share * all.used()), b = budgetOf(share * all.used());
    const RefinedWindow one = search.run(wrong, &a), two = search.run(wrong, &b);
    ASSERT_EQ(one.valid, two.valid);
    EXPECT_EQ(a.used(), b.used());
    EXPECT_NE(a.takeLeftOut(), "");
    if (one.valid) {
      EXPECT_EQ(one.state.p_b0, two.state.p_b0);
    }
  }
}

TEST(WorkBudget, SharesAreOfWhatIsLeft) {
  WorkBudget budget = budgetOf(100.0);
  budget.spend(20.0);
  {
    const WorkBudget::Share share(0.5, &budget);
    budget.spend(39.0);
    EXPECT_TRUE(budget.allows("nothing"));
    budget.spend(1.0);
    EXPECT_FALSE(budget.allows("the first"));
    EXPECT_FALSE(budget.allows("the second"));
  }
  EXPECT_TRUE(budget.allows("nothing"));
  EXPECT_NE(budget.takeLeftOut().find("skipped the first"), std::string::npos);
  budget.spend(40.0);
  EXPECT_TRUE(budget.isUsedUp());
  WorkBudget unlimited = unlimitedBudget();
  unlimited.spend(1e300);
  EXPECT_FALSE(unlimited.isUsedUp());
  EXPECT_GT(measuredWorkPerMs(), 1.0);
  EXPECT_EQ(measuredWorkPerMs(), measuredWorkPerMs());
}

}  // namespace
}  // namespace slim_init
