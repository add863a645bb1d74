// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init ab --downstream` as a user runs it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "evaluation/scratch_folder.h"
#include "tools/run_program.h"

namespace slim_init {
namespace {

ProgramRun runAb(const ScratchFolder& folder, const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"ab", "--builtin", "circle",          "--duration",
                                        "12", "--methods", "drt-l",           "--limit",
                                        "2",  "--out",     folder.file("out")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return runProgram(folder, arguments);
}

TEST(AbDownstream, ReportsTheRuns) {
  const ScratchFolder folder;
  const ProgramRun run = runAb(folder, {"--downstream", "3"});
#ifdef SLIM_INIT_HAS_BACKEND
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(readFile(folder.file("out/summary.json")));
  const auto& all = json["methods"]["drt-l"]["all"];
  EXPECT_EQ(json["options"]["downstream_s"], 3.0);
  EXPECT_EQ(all["downstream_runs"], 2);
  EXPECT_EQ(all["downstream_diverged"], 0);
  EXPECT_LT(all["downstream_ate_median"].get<double>(), 0.1);
  EXPECT_LT(all["downstream_scale_median"].get<double>(), 0.05);
#else
  EXPECT_EQ(run.exit_code, 2);
  expectParts(run.err, "built without the back end");
#endif
}

TEST(AbDownstream, WithoutItNothingRuns) {
  const ScratchFolder folder;
  const ProgramRun run = runAb(folder, {});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(readFile(folder.file("out/summary.json")));
  EXPECT_EQ(json["methods"]["drt-l"]["all"]["downstream_runs"], 0);
  EXPECT_TRUE(json["methods"]["drt-l"]["all"]["downstream_ate_median"].is_null());
}

}  // namespace
}  // namespace slim_init
