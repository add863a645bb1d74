// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init ab --suite` as a user runs it.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "evaluation/html_check.h"
#include "evaluation/scratch_folder.h"
#include "tools/run_program.h"
#include "tools/small_recording.h"

namespace slim_init {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// A suite of one or two windows a case.
ProgramRun runSuite(const ScratchFolder& folder, const std::string& out,
                    const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {
      "ab",        "--suite",          "paper", "--quick",       "--limit", "2",
      "--methods", "slim-paper,drt-l", "--out", folder.file(out)};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return runProgram(folder, arguments);
}

Json suiteJson(const ScratchFolder& folder, const std::string& out) {
  return Json::parse(readFile(folder.file(out) + "/suite.json"));
}

std::vector<std::string> caseFolders(const Json& suite) {
  std::vector<std::string> folders;
  for (const auto& entry : suite["cases"]) folders.push_back(entry["folder"].get<std::string>());
  return folders;
}

/// Without what depends on the clock and on where the files are.
Json withoutTimes(Json json) {
  if (json.is_object()) {
    for (auto it = json.begin(); it != json.end();) {
      const bool drop = it.key().rfind("solve_", 0) == 0 || it.key() == "command";
      if (!drop) *it = withoutTimes(*it);
      it = drop ? json.erase(it) : std::next(it);
    }
  } else if (json.is_array()) {
    for (Json& item : json) item = withoutTimes(item);
  }
  return json;
}

std::string windowsOf(const ScratchFolder& folder, const std::string& out,
                      const std::string& name) {
  return readFile(folder.file(out) + "/" + name + "/windows.csv");
}

TEST(Suite, BadCommandsExitWithTwoAndASentence) {
  const ScratchFolder folder;
  fs::create_directories(folder.file("empty/inside"));
  writeRecording(folder, 4.0, 0.0);
  const std::vector<std::pair<std::vector<std::string>, std::string>> commands = {
      {{"--suite", "poster"}, "--suite is 'poster', must be paper"},
      {{"--suite", "paper", "--builtin", "circle"}, "--builtin does not go with --suite"},
      {{"--suite", "paper", "--asl", "x"}, "--asl does not go with --suite"},
      {{"--suite", "paper", "--bag", "x"}, "--bag does not go with --suite"},
      {{"--suite", "paper", "--keyframes", "8"}, "--keyframes does not go with --suite"},
      {{"--suite", "paper", "--ablation"}, "--ablation does not go with --suite"},
      {{"--suite", "paper", "--methods", "drt-l,magic"}, "--methods names 'magic'"},
      {{"--suite", "paper", "--recorded", ""}, "--recorded is empty"},
      {{"--suite", "paper", "--recorded", folder.file("no")}, "--recorded: there is no folder"},
      {{"--suite", "paper", "--recorded", folder.file("empty")}, "holds a recording (imu0.csv)"},
      {{"--suite", "paper", "--recorded", folder.path()}, "is one recording"},
      {{"--suite", "paper", "--euroc", folder.file("no")}, "--euroc: there is no folder"},
      {{"--suite", "paper", "--euroc", folder.file("empty")},
       "--euroc: none of EuRoC's sequences is in " + folder.file("empty")},
      {{"--suite", "paper", "--downstream-every", "2"}, "no effect without --downstream"},
      {{"--suite", "paper", "--config", "x"}, "--config is, with --suite, for the bags"},
      {{"--builtin", "circle", "--euroc", "x"}, "--euroc is for --suite"},
      {{"--builtin", "circle", "--quick"}, "--quick is for --suite"},
      {{"--builtin", "circle", "--downstream-every", "2"}, "no effect without --downstream"}};
  for (const auto& [arguments, sentence] : commands) {
    std::vector<std::string> words = {"ab", "--out", folder.file("out")};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const ProgramRun run = runProgram(folder, words);
    EXPECT_EQ(run.exit_code, 2) << sentence;
    EXPECT_TRUE(contains(run.err, sentence)) << sentence << "\n" << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_FALSE(fs::exists(folder.file("out"))) << sentence;
  }
}

TEST(Suite, ABagNeedsItsConfiguration) {
  const ScratchFolder folder;
  fs::create_directories(folder.file("machine_hall/MH_02_easy"));
  folder.write("machine_hall/MH_02_easy/MH_02_easy.bag", "");
  const ProgramRun run = runSuite(folder, "out", {"--euroc", folder.path()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(contains(run.err, "MH_02_easy.bag is a bag and needs --config YAML")) << run.err;
}

TEST(Suite, RunsEveryCaseAndTabulatesEveryMethod) {
  const ScratchFolder folder;
  for (const char* name : {"MH_03", "V1_01", "papers"}) fs::create_directories(folder.file(name));
  writeRecording(folder, 6.0, 0.0, "MH_03/");
  writeRecording(folder, 6.0, 0.0, "V1_01/");
  const ProgramRun run =
      runSuite(folder, "papers/out", {"--recorded", folder.path(), "--threads", "2"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains(run.err, "--recorded: papers has no imu0.csv and was passed over"));

  const Json suite = suiteJson(folder, "papers/out");
  const std::vector<std::string> folders = caseFolders(suite);
  EXPECT_EQ(folders,
            (std::vector<std::string>{
                "recorded/MH_03", "recorded/V1_01", "simulated/corridor-walk",
                "simulated/constant-velocity-12", "simulated/constant-velocity",
                "simulated/pure-rotation", "simulated/hover", "simulated/circle",
                "simulated/figure-eight", "ablation/recorded/MH_03", "ablation/recorded/V1_01",
                "ablation/simulated/corridor-walk", "ablation/simulated/constant-velocity-12"}));
  const std::string markdown = readFile(folder.file("papers/out/suite.md"));
  const std::string html = readFile(folder.file("papers/out/report.html"));
  EXPECT_EQ(htmlProblem(html), "");
  for (const auto& entry : suite["cases"]) {
    const std::string name = entry["name"].get<std::string>();
    const std::string place = entry["folder"].get<std::string>();
    EXPECT_TRUE(contains(run.out, place + ": ")) << run.out;
    EXPECT_EQ(entry["summary"]["options"]["drift"], 0.04) << name;
    EXPECT_EQ(entry["summary"]["options"]["outliers"], 0.03) << name;
    EXPECT_GE(entry["summary"]["trials"]["windows"].get<int>(), 1) << name;
    for (const char* file : {"windows.csv", "summary.json", "report.md", "report.html"}) {
      EXPECT_TRUE(fs::exists(folder.file("papers/out/") + place + "/" + file)) << place;
    }
    if (entry["ablation"].get<bool>()) {
      EXPECT_TRUE(entry["summary"]["methods"].contains("slim-paper[no-lines]")) << name;
      EXPECT_FALSE(entry["summary"]["methods"].contains("drt-l")) << name;
      continue;
    }
    for (const char* method : {"slim-paper", "drt-l"}) {
      EXPECT_TRUE(contains(markdown, "| " + name + " | " + method + " | ")) << name;
      EXPECT_TRUE(contains(
          html, "<td class=\"name\">" + name + "</td><td class=\"name\">" + method + "</td>"))
          << name;
    }
  }
  EXPECT_EQ(suite["cases"][0]["summary"]["options"]["world"], "hall");
  EXPECT_EQ(suite["cases"][1]["summary"]["options"]["world"], "room");
  EXPECT_EQ(suite["cases"][2]["summary"]["options"]["points"], 12);
  // The printed figures of these sequences.
  EXPECT_TRUE(contains(markdown, "(0.119)")) << markdown;
  EXPECT_TRUE(contains(markdown, "(0.127)")) << markdown;
  EXPECT_TRUE(contains(run.out, "Table III, degenerate motion")) << run.out;
}

TEST(Suite, GoesOnWhereItWasInterrupted) {
  const ScratchFolder folder;
  ASSERT_EQ(runSuite(folder, "whole").exit_code, 0);
  const Json whole = suiteJson(folder, "whole");
  const std::vector<std::string> folders = caseFolders(whole);
  ASSERT_EQ(folders.size(), 9u);

  // As after an interruption in the third case: a line cut short, nothing after it.
  fs::copy(folder.file("whole"), folder.file("cut"), fs::copy_options::recursive);
  for (const char* file : {"suite.md", "suite.json", "report.html"}) {
    fs::remove(folder.file("cut/") + file);
  }
  const std::string third = folder.file("cut/") + folders[2];
  const std::string journal = readFile(third + "/windows.journal");
  const std::size_t second_window = journal.find('\n', journal.find('\n') + 1) + 1;
  ASSERT_LT(second_window, journal.size());
  fs::remove_all(third);
  fs::create_directories(third);
  folder.write("cut/" + folders[2] + "/windows.journal", journal.substr(0, second_window + 40));
  for (std::size_t i = 3; i < folders.size(); ++i) {
    fs::remove_all(folder.file("cut/") + folders[i]);
  }
  // Threads have no bearing on the answers.
  const ProgramRun run = runSuite(folder, "cut", {"--threads", "2"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains(run.out, folders[0] + ": 2 windows, finished before")) << run.out;
  EXPECT_TRUE(contains(run.out, folders[1] + ": 2 windows, finished before")) << run.out;
  EXPECT_TRUE(contains(run.out, folders[2] + ": 2 windows, 1 of them solved before")) << run.out;
  EXPECT_TRUE(contains(run.out, folders[3] + ": 2 windows\n")) << run.out;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    const std::string before = windowsOf(folder, "whole", folders[i]);
    const std::string after = windowsOf(folder, "cut", folders[i]);
    EXPECT_EQ(slim_init::withoutTimes(before), slim_init::withoutTimes(after)) << folders[i];
    // Not even the times of what was finished have changed; those of what was not have.
    EXPECT_EQ(before == after, i < 2) << folders[i];
  }
  EXPECT_EQ(withoutTimes(whole), withoutTimes(suiteJson(folder, "cut")));

  // Other options begin anew and say so.
  const ProgramRun other = runSuite(folder, "cut", {"--seed", "2"});
  ASSERT_EQ(other.exit_code, 0) << other.err;
  EXPECT_FALSE(contains(other.out, "before")) << other.out;
  EXPECT_TRUE(contains(other.err, "slim_init: note: " + folders[0] + ": ")) << other.err;
  EXPECT_NE(slim_init::withoutTimes(windowsOf(folder, "whole", folders[0])),
            slim_init::withoutTimes(windowsOf(folder, "cut", folders[0])));
}

TEST(Suite, ACaseThatCannotBeRunIsNamedAndTheOthersAreRun) {
  const ScratchFolder folder;
  for (const char* name : {"data", "data/MH_03", "data/V1_01"}) {
    fs::create_directories(folder.file(name));
  }
  writeRecording(folder, 6.0, 0.0, "data/MH_03/");
  writeRecording(folder, 6.0, 0.0, "data/V1_01/");
  folder.write("data/V1_01/groundtruth.csv", "#nothing\n");
  const ProgramRun run = runSuite(folder, "out", {"--recorded", folder.file("data")});
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_TRUE(contains(run.err, "slim_init: recorded/V1_01: ")) << run.err;
  EXPECT_TRUE(contains(run.err, "groundtruth.csv")) << run.err;
  const Json suite = suiteJson(folder, "out");
  EXPECT_EQ(suite["failed"].size(), 2u);  // and its ablation
  EXPECT_EQ(suite["cases"].size(), 11u);
  EXPECT_TRUE(contains(readFile(folder.file("out/suite.md")), "NOT RUN: recorded/V1_01: "));
}

}  // namespace
}  // namespace slim_init
