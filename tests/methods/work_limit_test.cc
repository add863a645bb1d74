// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The limit on the work of one solve, as a host sees it. A fixed work_per_ms makes a limit in time
// one of counted work, so that nothing here depends on the machine.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "slim_init/initializer.h"
#include "support/data_sheet_options.h"
#include "support/exact_window.h"
#include "support/fed_initializer.h"
#include "support/same_result.h"

namespace slim_init {
namespace {

std::unique_ptr<IInitializer> makeLimited(const ExactWindow& exact, double units) {
  InitializerOptions options = dataSheetOptions();
  options.limits.max_solve_ms = units > 0.0 ? 1.0 : 0.0;
  options.limits.work_per_ms = units;
  return makeFed(exact, options);
}

// From no work at all to all of it: a solve ends with the right estimate, or with the limit. Never
// is an estimate accepted that the whole solve would not give, and equal work gives equal bytes.
TEST(WorkLimit, WhatIsAcceptedIsWhatTheWholeSolveGives) {
  const ExactWindow exact = makeExactWindow(drawnStream(3, Motion::kExcited, 16));
  const InitResult whole = makeLimited(exact, 0.0)->initialize();
  ASSERT_TRUE(whole.success()) << whole.message;
  int limited = 0, accepted = 0;
  for (double units = 10.0; units < 1e6; units *= 1.5) {
    const InitResult result = makeLimited(exact, units)->initialize();
    EXPECT_TRUE(sameBytes(result, makeLimited(exact, units)->initialize())) << units;
    if (result.success()) {
      ++accepted;
      EXPECT_EQ(result.scale, whole.scale) << units;
    } else {
      ++limited;
      EXPECT_EQ(result.status, InitStatus::kTimeLimit) << units << ": " << result.message;
      EXPECT_EQ(result.message.find("the time limit of 1 ms (limits.max_solve_ms) skipped "), 0u)
          << result.message;
      EXPECT_EQ(accepted, 0) << "more work, less certain: " << units;
    }
  }
  EXPECT_GT(limited, 3);
  EXPECT_GT(accepted, 3);
  EXPECT_TRUE(sameBytes(makeLimited(exact, 1e6)->initialize(), whole)) << "not reached";
}

// At constant velocity the window alone has no estimate; what it may cost is bounded, so that there
// is work left for the known state.
TEST(WorkLimit, ARecoveryKeepsWorkForTheKnownState) {
  const ExactWindow exact = makeExactWindow(drawnStream(3, Motion::kConstantVelocity, 16));
  const std::vector<StatePrior> healthy = {healthyPrior(exact.truth[8])};
  const InitResult whole = makeLimited(exact, 0.0)->initialize({healthy, {}});
  ASSERT_TRUE(whole.success()) << whole.message;
  int accepted = 0;
  for (double units = 10.0; units < 1e6; units *= 1.5) {
    const InitResult result = makeLimited(exact, units)->initialize({healthy, {}});
    if (!result.success()) {
      EXPECT_EQ(accepted, 0) << units << ": " << result.message;
      continue;
    }
    ++accepted;
    EXPECT_EQ(result.states.back().v_w_b, whole.states.back().v_w_b) << units;
  }
  EXPECT_GT(accepted, 3);
}

}  // namespace
}  // namespace slim_init
