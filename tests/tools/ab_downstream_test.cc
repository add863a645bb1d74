// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init ab --downstream` as a user runs it.
#include "tools/ab_runs.h"

namespace slim_init {
namespace {

using AbDownstream = AbRuns;

const std::string kTwoWindows = "--builtin circle --duration 12 --methods drt-l --limit 2";

TEST_F(AbDownstream, ReportsTheRuns) {
  const auto json = summary(kTwoWindows + " --downstream 3");
  const auto& all = json["methods"]["drt-l"]["all"];
  EXPECT_EQ(json["options"]["downstream_s"], 3.0);
  EXPECT_EQ(all["downstream_runs"], 2);
  EXPECT_EQ(all["downstream_diverged"], 0);
  EXPECT_LT(all["downstream_ate_median"].get<double>(), 0.1);
  EXPECT_LT(all["downstream_scale_median"].get<double>(), 0.05);
}

TEST_F(AbDownstream, WithoutItNothingRuns) {
  const auto all = summary(kTwoWindows)["methods"]["drt-l"]["all"];
  EXPECT_EQ(all["downstream_runs"], 0);
  EXPECT_TRUE(all["downstream_ate_median"].is_null());
}

}  // namespace
}  // namespace slim_init
