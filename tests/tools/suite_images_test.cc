// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init ab --suite paper --euroc` on folders that are named like EuRoC's.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "evaluation/html_check.h"
#include "evaluation/scratch_folder.h"
#include "slim_init/evaluation/image_sequence.h"
#include "tools/run_program.h"
#include "tools/wall_recording.h"

namespace slim_init {
namespace {

TEST(SuiteImages, FindsEurocsSequencesByName) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder.file("euroc/machine_hall/unrelated"));
  Wall::writeAsl(folder.file("euroc/machine_hall/MH_01_easy"));  // as the archives unpack
  Wall::writeAsl(folder.file("euroc/V2_01_easy"));
  const ProgramRun run = runProgram(
      folder, {"ab", "--suite", "paper", "--quick", "--limit", "2", "--euroc", folder.file("euroc"),
               "--methods", "drt-l,slim-paper", "--out", folder.file("out")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains(run.err,
                       "--euroc: not found: MH_02_easy, MH_03_medium, MH_04_difficult, "
                       "MH_05_difficult, V1_01_easy, V1_02_medium, V1_03_difficult, "
                       "V2_02_medium, V2_03_difficult"))
      << run.err;
  const auto suite = nlohmann::json::parse(readFile(folder.file("out/suite.json")));
  EXPECT_EQ(suite["cases"][0]["folder"], "images/MH_01");
  EXPECT_EQ(suite["cases"][1]["folder"], "images/V2_01");
  EXPECT_EQ(suite["cases"][1]["group"], "Vicon Room 2");
  EXPECT_EQ(suite["cases"][0]["summary"]["tracking"]["images"], 81);
  EXPECT_EQ(suite["cases"][0]["summary"]["methods"]["drt-l"]["all"]["windows"], 2);
  const std::string markdown = readFile(folder.file("out/suite.md"));
  EXPECT_TRUE(contains(markdown, "## Table I, accuracy: EuRoC, from images")) << markdown;
  EXPECT_TRUE(contains(markdown, "| method | MH_01 | V2_01 | mean |")) << markdown;
  // What the paper printed for drt-l there, and its mean of the two.
  EXPECT_TRUE(contains(markdown, "(0.120) |")) << markdown;
  EXPECT_TRUE(contains(markdown, "(0.137) |")) << markdown;
  const std::string html = readFile(folder.file("out/report.html"));
  EXPECT_EQ(htmlProblem(html), "");

  // The picture of several cases together; 3 says that there is no matplotlib.
  const std::string draw = "python3 \"" SLIM_INIT_SOURCE_DIR
                           "/slim_init/evaluation/scripts/plot_report.py\" \"" +
                           folder.file("out") + "\" images_ \"" + folder.file("out/images/MH_01") +
                           "\" \"" + folder.file("out/images/V2_01") + "\"";
  const int status = std::system(draw.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  // Pictures are optional; that a report without them says so is tested in ab_test.
  if (WEXITSTATUS(status) == 3) GTEST_SKIP() << "there is no matplotlib";
  ASSERT_EQ(WEXITSTATUS(status), 0);
  for (const char* picture : {"images_error_cdf.png", "images_solve_time.png"}) {
    EXPECT_GT(std::filesystem::file_size(folder.file("out/") + picture), 1000u) << picture;
  }
}

TEST(SuiteImages, TakesBagsWithAConfiguration) {
  // rosbag is optional; that a build without it says so is tested in image_sequence_test.
  if (!evaluation::rosbagSupported()) GTEST_SKIP() << "this build is without rosbag";
  const ScratchFolder folder;
  std::filesystem::create_directories(folder.file("euroc/MH_01_easy"));
  Wall::writeBag(folder.file("euroc/MH_01_easy/MH_01_easy.bag"));
  std::filesystem::remove(
      evaluation::groundtruthFileOf(folder.file("euroc/MH_01_easy/MH_01_easy.bag")));
  folder.write("config.yaml", Wall::config());
  const ProgramRun run =
      runProgram(folder, {"ab", "--suite", "paper", "--quick", "--limit", "1", "--euroc",
                          folder.file("euroc"), "--methods", "drt-l", "--config",
                          folder.file("config.yaml"), "--out", folder.file("out")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto suite = nlohmann::json::parse(readFile(folder.file("out/suite.json")));
  EXPECT_EQ(suite["cases"][0]["folder"], "images/MH_01");
  EXPECT_EQ(suite["cases"][0]["summary"]["has_truth"], false);
  // The rig of the bags is not that of the simulated features.
  EXPECT_FALSE(suite["cases"][1]["summary"]["options"].contains("config"));
  EXPECT_TRUE(contains(readFile(folder.file("out/suite.md")),
                       "- images/MH_01: no ground truth, so no errors and no success"));
}

}  // namespace
}  // namespace slim_init
