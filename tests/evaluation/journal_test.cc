// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/journal.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>

#include "evaluation/scratch_folder.h"
#include "evaluation/varied_solver.h"
#include "slim_init/evaluation/report.h"

namespace slim_init::evaluation {
namespace {

constexpr double kSeconds = 8.0;  // 12 windows

/// Two methods over the circle, with a journal or without.
struct TwoMethods {
  VariedSolver first{"first"}, second{"second", 2.0};
  ProtocolOptions options;
  ProtocolResult result;

  std::string operator()(WindowJournal* journal) {
    options.journal = journal;
    options.downstream = runNothing;
    return runProtocol(makeCircleSequence(kSeconds), {&first, &second}, options, nullptr, &result);
  }
  std::string csv() const {
    RunInfo info;
    info.dataset = "circle";
    return windowsCsv(info, result);
  }
};

/// A run with a journal in `file`. Returns what the journal had to note.
std::string runWith(const std::string& file, TwoMethods* run,
                    const std::string& fingerprint = "print") {
  WindowJournal journal;
  std::string note;
  EXPECT_EQ(journal.open(file, fingerprint, &note), "");
  EXPECT_EQ((*run)(&journal), "");
  return note;
}

bool sameBits(double a, double b) { return std::memcmp(&a, &b, sizeof(double)) == 0; }

TEST(Journal, ResumesWithoutSolvingAgain) {
  const ScratchFolder folder;
  const std::string file = folder.file("windows.journal");
  TwoMethods first;
  EXPECT_EQ(runWith(file, &first), "");
  EXPECT_EQ(first.result.from_journal, 0);
  ASSERT_EQ(first.result.windows.size(), 12u);
  const std::string text = readFile(file);

  TwoMethods again;
  EXPECT_EQ(runWith(file, &again), "");
  EXPECT_EQ(again.first.solved, 0);
  EXPECT_EQ(again.result.from_journal, 12);
  EXPECT_EQ(again.csv(), first.csv());  // times included
  EXPECT_EQ(readFile(file), text);
}

TEST(Journal, ContinuesWhereverItWasCut) {
  const ScratchFolder folder;
  TwoMethods whole;
  runWith(folder.file("whole"), &whole);
  const std::string text = readFile(folder.file("whole"));
  forgetTimes(&whole.result);
  std::vector<std::size_t> ends;  // of the lines
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n') ends.push_back(i + 1);
  }
  ASSERT_EQ(ends.size(), 13u);
  struct Cut {
    std::size_t bytes;
    int windows;
    bool in_a_line;
  };
  for (const Cut& cut : {Cut{ends[0], 0, false}, Cut{ends[4], 4, false}, Cut{ends[4] + 1, 4, true},
                         Cut{(ends[4] + ends[5]) / 2, 4, true}, Cut{ends[5] - 1, 4, true},
                         Cut{ends[12] - 1, 11, true}}) {
    const std::string file = folder.file("cut");
    folder.write("cut", text.substr(0, cut.bytes));
    TwoMethods resumed;
    resumed.options.threads = 2;
    const std::string note = runWith(file, &resumed);
    EXPECT_EQ(note,
              cut.in_a_line ? "1 line of " + file + " cut short or not readable, dropped" : "")
        << cut.bytes;
    EXPECT_EQ(resumed.result.from_journal, cut.windows) << cut.bytes;
    EXPECT_EQ(resumed.first.solved, 12 - cut.windows) << cut.bytes;
    forgetTimes(&resumed.result);
    EXPECT_EQ(resumed.csv(), whole.csv()) << cut.bytes;
    // Nothing of the torn line is left to spoil the next start.
    TwoMethods third;
    EXPECT_EQ(runWith(file, &third), "") << cut.bytes;
    EXPECT_EQ(third.first.solved, 0) << cut.bytes;
  }
}

TEST(Journal, GivesEveryNumberBackBitByBit) {
  const ScratchFolder folder;
  TwoMethods run;
  runWith(folder.file("j"), &run);
  WindowJournal journal;
  std::string note;
  ASSERT_EQ(journal.open(folder.file("j"), "print", &note), "");
  ASSERT_EQ(journal.size(), 12);
  EXPECT_EQ(journal.find(12), nullptr);
  for (const WindowRecord& a : run.result.windows) {
    const WindowRecord* b = journal.find(a.trial);
    ASSERT_NE(b, nullptr);
    EXPECT_EQ(a.t_start_ns, b->t_start_ns);
    EXPECT_TRUE(sameBits(a.t_start, b->t_start));
    EXPECT_TRUE(sameBits(a.excitation.mean_deviation, b->excitation.mean_deviation));
    EXPECT_TRUE(sameBits(a.p_w_b.y(), b->p_w_b.y()));
    ASSERT_EQ(b->methods.size(), 2u);
    for (std::size_t m = 0; m < 2; ++m) {
      const MethodRecord &x = a.methods[m], &y = b->methods[m];
      EXPECT_EQ(x.status, y.status);
      EXPECT_EQ(x.message, y.message);
      EXPECT_EQ(x.metrics.failure, y.metrics.failure);
      EXPECT_TRUE(sameBits(x.solve_ms, y.solve_ms));
      EXPECT_TRUE(sameBits(x.solve_cpu_ms, y.solve_cpu_ms));
      EXPECT_EQ(std::isnan(x.scale_sigma), std::isnan(y.scale_sigma));
      if (!x.attempted) {
        EXPECT_TRUE(std::isnan(y.metrics.scale_error));
        EXPECT_TRUE(sameBits(x.partial.gyro_bias_vec_err, y.partial.gyro_bias_vec_err));
        continue;
      }
      EXPECT_TRUE(sameBits(x.scale_sigma, y.scale_sigma));
      EXPECT_TRUE(sameBits(x.metrics.scale_error, y.metrics.scale_error));
      EXPECT_TRUE(sameBits(x.metrics.gravity_error_deg, y.metrics.gravity_error_deg));
      EXPECT_EQ(x.downstream.ran, y.downstream.ran);
      ASSERT_EQ(y.gates.size(), 3u);
      EXPECT_TRUE(sameBits(x.gates[0].value, y.gates[0].value));
      EXPECT_EQ(y.gates[0].threshold, std::numeric_limits<double>::infinity());
      EXPECT_EQ(y.gates[0].explanation, "what was measured");
      EXPECT_EQ(y.gates[0].unit, "px");
      EXPECT_TRUE(std::isnan(y.gates[1].value));
      EXPECT_TRUE(sameBits(y.gates[2].value, -0.0));
      EXPECT_EQ(y.gates[2].threshold, -std::numeric_limits<double>::infinity());
      EXPECT_TRUE(y.gates[2].passed && y.gates[2].enforced && !y.gates[2].upper_bound);
      EXPECT_EQ(y.gates[2].status_if_failed, InitStatus::kScaleTooUncertain);
      ASSERT_EQ(y.stages.size(), 2u);
      EXPECT_TRUE(sameBits(x.stages[0].ms, y.stages[0].ms));
    }
  }
}

TEST(Journal, OtherFingerprintBeginsAnewAndSaysSo) {
  const ScratchFolder folder;
  const std::string file = folder.file("j");
  TwoMethods run;
  runWith(file, &run, "seed 1");
  for (const std::string other : {"seed 10", "seed ", "", "seed 1\nseed 1"}) {
    TwoMethods second;
    EXPECT_NE(runWith(file, &second, other).find(file + " is of a run with other data"),
              std::string::npos)
        << other;
    EXPECT_EQ(second.first.solved, 12);
    TwoMethods third;
    EXPECT_EQ(runWith(file, &third, other), "");
    EXPECT_EQ(third.first.solved, 0);
  }
  // So does a file that is none of ours.
  folder.write("j", "something\nelse\n");
  TwoMethods fourth;
  EXPECT_NE(runWith(file, &fourth), "");
  EXPECT_EQ(fourth.first.solved, 12);
}

TEST(Journal, LinesThatCannotBeReadAreDroppedAndCounted) {
  const ScratchFolder folder;
  const std::string file = folder.file("j");
  TwoMethods whole;
  runWith(file, &whole);
  std::string text = readFile(file);
  const std::size_t second = text.find('\n', text.find('\n') + 1) + 1;
  text.insert(second, "{\"trial\":3}\n[1,2\n");
  const std::size_t status = text.find("\"status\":\"success\"");
  ASSERT_NE(status, std::string::npos);
  text.replace(status, 18, "\"status\":[\"succes\"]");
  folder.write("j", text);
  TwoMethods resumed;
  EXPECT_EQ(runWith(file, &resumed).rfind("3 lines of ", 0), 0u);
  EXPECT_EQ(resumed.first.solved, 1);
  forgetTimes(&whole.result);
  forgetTimes(&resumed.result);
  EXPECT_EQ(resumed.csv(), whole.csv());
}

TEST(Journal, WindowsOfOtherDataAreSolvedAgain) {
  const ScratchFolder folder;
  TwoMethods run;
  runWith(folder.file("j"), &run);
  WindowJournal journal;
  std::string note;
  ASSERT_EQ(journal.open(folder.file("j"), "print", &note), "");
  ProtocolOptions options;
  options.journal = &journal;
  ProtocolResult result;
  Sequence later = makeCircleSequence(kSeconds);
  later.t0_ns += 1;
  const VariedSolver first("first"), second("second");
  ASSERT_EQ(runProtocol(later, {&first, &second}, options, nullptr, &result), "");
  EXPECT_EQ(result.from_journal, 0);
  EXPECT_EQ(first.solved, 12);
  // Nor do answers of two methods serve for one.
  ASSERT_EQ(runProtocol(later, {&first}, options, nullptr, &result), "");
  EXPECT_EQ(result.from_journal, 0);
  EXPECT_EQ(result.windows[0].methods.size(), 1u);
}

TEST(Journal, AFileThatCannotBeWrittenIsASentence) {
  const ScratchFolder folder;
  WindowJournal journal;
  std::string note;
  EXPECT_EQ(journal.open(folder.file("no/such/folder/j"), "print", &note),
            folder.file("no/such/folder/j") + " cannot be written");
  EXPECT_EQ(journal.open(folder.path(), "print", &note), folder.path() + " cannot be written");
}

TEST(Journal, AFullDiskStopsTheRunWithASentence) {
  const ScratchFolder folder;
  const std::string file = folder.file("j");
  WindowJournal journal;
  std::string note;
  ASSERT_EQ(journal.open(file, "print", &note), "");
  TwoMethods run;
  run.options.threads = 2;
  rlimit before = {};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 8000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error = run(&journal);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(error, file + " cannot be written");
  EXPECT_GT(run.first.solved, 0);
  EXPECT_LT(run.first.solved, 12);
  // With room again, what was written is of use.
  TwoMethods resumed;
  EXPECT_NE(runWith(file, &resumed), "");
  EXPECT_GT(resumed.result.from_journal, 0);
  EXPECT_EQ(resumed.first.solved + resumed.result.from_journal, 12);
}

}  // namespace
}  // namespace slim_init::evaluation
