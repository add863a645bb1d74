// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The tables of a suite from results made by hand.
#include "suite_tables.h"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluation/html_check.h"
#include "paper_figures.h"
#include "slim_init/evaluation/page.h"
#include "suite_page.h"

namespace slim_init::tools {
namespace {

using evaluation::MethodSummary;
using evaluation::Table;

constexpr PaperMetric kMetrics[] = {PaperMetric::kScale, PaperMetric::kGravityDeg,
                                    PaperMetric::kVelocity, PaperMetric::kPose};
constexpr const char* kPaperMethods[] = {"vins", "openvins", "drt-l", "slim-paper"};

/// A window of 2.25 s in which every method is off by its own error; NaN: it found nothing.
evaluation::WindowRecord window(int trial, const std::vector<double>& scale_errors) {
  evaluation::WindowRecord record;
  record.trial = trial;
  record.t_start = 0.5 * trial;
  record.duration_s = 2.25;
  record.keyframes = 10;
  record.excitation.excited = true;
  for (const double error : scale_errors) {
    evaluation::MethodRecord answer;
    answer.attempted = std::isfinite(error);
    answer.status = answer.attempted ? InitStatus::kSuccess : InitStatus::kTooFewTracks;
    answer.solve_ms = answer.solve_cpu_ms = 2.0;
    if (answer.attempted) {
      answer.metrics.scale = 1.0 + error;
      answer.metrics.scale_error = error;
      answer.metrics.gravity_error_deg = 10.0 * error;
      answer.metrics.velocity_rmse = error;
      answer.metrics.velocity_vec_rmse = error;
      answer.metrics.pose_rmse = error;
      answer.metrics.gyro_bias_err_pct = error;
      answer.metrics.gyro_bias_vec_err = error;
    } else {
      answer.metrics.failure = "no estimate";
    }
    record.methods.push_back(answer);
  }
  return record;
}

constexpr int kWindows = 30;

/// A case in which slim succeeds in all windows and drt-l in every third.
SuiteResult someCase(const std::string& name, const std::string& group, CaseKind kind,
                     double slim_error, double drt_error) {
  SuiteResult result;
  result.entry.name = name;
  result.entry.group = group;
  result.entry.kind = kind;
  result.entry.paper_column = kind == CaseKind::kBuiltin ? "" : name;
  result.entry.options.builtin = kind == CaseKind::kBuiltin ? name : "";
  result.run.result.methods = {"slim", "drt-l"};
  for (int i = 0; i < kWindows; ++i) {
    result.run.result.windows.push_back(
        window(i, {slim_error, i % 3 == 0 ? drt_error : kNotComputed}));
  }
  result.run.result.counts.trials = kWindows + 2;
  result.run.result.counts.windows = kWindows;
  result.run.summaries = evaluation::summarize(result.run.result);
  return result;
}

SuiteReport someReport() {
  SuiteReport report;
  report.command = "slim_init ab --suite paper";
  report.program = "slim_init 1.2.3";
  report.methods = {"slim", "drt-l"};
  report.results = {someCase("MH_03", "Machine Hall", CaseKind::kRecorded, 0.03, 0.2),
                    someCase("MH_04", "Machine Hall", CaseKind::kRecorded, 0.05, 0.1),
                    someCase("V1_01", "Vicon Room 1", CaseKind::kRecorded, 0.2, 0.1),
                    someCase("corridor-walk", "Degenerate", CaseKind::kBuiltin, 0.04, 0.3),
                    someCase("hover", "Without parallax", CaseKind::kBuiltin, 0.4, 0.3)};
  report.notes = {"a note <here>"};
  report.failed = {"recorded/V2_01: its imu0.csv is broken"};
  groupResults(&report);
  return report;
}

/// The cell of the row that begins with `names`.
const evaluation::TableCell& cellOf(const Table& table, const std::vector<std::string>& names,
                                    const std::string& column) {
  static const evaluation::TableCell kNone("no such cell");
  for (const auto& row : table.rows) {
    bool found = true;
    for (std::size_t i = 0; i < names.size(); ++i) found = found && row[i].text == names[i];
    for (std::size_t c = 0; found && c < row.size(); ++c) {
      if (table.columns[c] == column) return row[c];
    }
  }
  return kNone;
}

// Whoever copies 176 numbers makes a mistake; the paper's own last column finds it.
TEST(PaperFigures, TheSequencesAverageToThePrintedAverage) {
  ASSERT_EQ(paperSequences().size(), 11u);
  for (const PaperMetric metric : kMetrics) {
    for (const char* method : kPaperMethods) {
      double sum = 0.0;
      for (const std::string& sequence : paperSequences()) {
        sum += paperAccuracy(metric, method, sequence);
      }
      // Eleven roundings to three digits and that of the average itself.
      EXPECT_NEAR(sum / 11.0, paperAccuracyAverage(metric, method), 1.0e-3)
          << method << " " << static_cast<int>(metric);
    }
  }
}

TEST(PaperFigures, WhatWasNotPrintedIsNaN) {
  EXPECT_TRUE(std::isnan(paperAccuracy(PaperMetric::kScale, "slim", "V1_01")));
  EXPECT_TRUE(std::isnan(paperAccuracy(PaperMetric::kScale, "drt-l", "")));
  EXPECT_TRUE(std::isnan(paperSuccess("drt-t", "Machine Hall")));
  EXPECT_TRUE(std::isnan(paperDegenerate(PaperMetric::kScale, "vins")));
  EXPECT_TRUE(std::isnan(paperSolveMs("slim")));
  EXPECT_EQ(paperSuccess("vins", "Vicon Room 1"), 22.97);
  EXPECT_EQ(paperAblation(PaperMetric::kGravityDeg, "slim-paper[no-line-normal]"), 4.196);
  // Its rows without lines are its rows of DRT-l.
  for (const PaperMetric metric : kMetrics) {
    EXPECT_EQ(paperAblation(metric, "slim-paper[no-lines]"), paperDegenerate(metric, "drt-l"));
    EXPECT_EQ(paperAblation(metric, "slim-paper"), paperDegenerate(metric, "slim-paper"));
  }
}

TEST(SuiteTables, AccuracyHasASequenceAColumnAndThePrintedFigureBeside) {
  const SuiteReport report = someReport();
  const std::vector<Table> tables =
      accuracyTables(report.groups.front().results, &MethodSummary::excited);
  ASSERT_EQ(tables.size(), 4u);
  const Table& scale = tables.front();
  EXPECT_EQ(scale.columns, (std::vector<std::string>{"method", "MH_03", "MH_04", "V1_01", "mean"}));
  ASSERT_EQ(scale.rows.size(), 2u);
  EXPECT_EQ(cellOf(scale, {"slim"}, "MH_03").text, "0.030");
  EXPECT_EQ(cellOf(scale, {"slim"}, "MH_03").beside, "");
  EXPECT_TRUE(cellOf(scale, {"slim"}, "MH_03").best);
  // A third of the windows.
  EXPECT_EQ(cellOf(scale, {"drt-l"}, "MH_03").text, "0.200\xE2\x80\xA0");
  EXPECT_EQ(cellOf(scale, {"drt-l"}, "MH_03").beside, "0.119");
  EXPECT_TRUE(cellOf(scale, {"drt-l"}, "V1_01").best);
  EXPECT_EQ(cellOf(scale, {"slim"}, "mean").text, "0.093");
  EXPECT_EQ(cellOf(scale, {"drt-l"}, "mean").beside, "0.134");  // of the three
}

TEST(SuiteTables, SuccessPoolsTheWindowsOfAGroup) {
  const SuiteReport report = someReport();
  const Table table = successTable(report.groups.front().results, &MethodSummary::all);
  EXPECT_EQ(cellOf(table, {"slim"}, "Machine Hall (MH_03, MH_04)").text, "100.0");
  EXPECT_EQ(cellOf(table, {"drt-l"}, "Machine Hall (MH_03, MH_04)").text, "33.3");
  EXPECT_EQ(cellOf(table, {"drt-l"}, "Machine Hall (MH_03, MH_04)").beside, "91.8");
  EXPECT_EQ(cellOf(table, {"drt-l"}, "Vicon Room 1 (V1_01)").beside, "72.1");
}

TEST(SuiteTables, OnlyTheWalkStandsBesideThePapersWalks) {
  const SuiteReport report = someReport();
  ASSERT_TRUE(report.groups[1].degenerate);
  const Table table = degenerateTable(report.groups[1].results);
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(cellOf(table, {"corridor-walk", "drt-l"}, "scale").beside, "0.166");
  EXPECT_EQ(cellOf(table, {"hover", "drt-l"}, "scale").beside, "");
  EXPECT_TRUE(cellOf(table, {"corridor-walk", "slim"}, "success %").best);
}

TEST(SuiteTables, EveryCaseAndMethodHasARow) {
  const SuiteReport report = someReport();
  SuiteResults all;
  for (const SuiteResult& result : report.results) all.push_back(&result);
  const Table table = detailTable(all, &MethodSummary::all);
  EXPECT_EQ(table.rows.size(), 10u);
  EXPECT_EQ(cellOf(table, {"MH_04", "drt-l"}, "windows").text, "30");
  EXPECT_EQ(cellOf(table, {"MH_04", "drt-l"}, "success %").text, "33.3");
  for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.columns.size());
}

TEST(SuiteTables, SaysWhereTheReferenceIsNotFirst) {
  const SuiteReport report = someReport();
  int figures = 0;
  const Table table = notFirstTable(detailTable(report.groups.front().results, &MethodSummary::all),
                                    "slim", &figures);
  // Success and twelve errors in each of three cases; in V1_01 all twelve errors are drt-l's.
  EXPECT_EQ(figures, 39);
  ASSERT_EQ(table.rows.size(), 12u);
  EXPECT_EQ(table.rows.front()[0].text, "V1_01");
  EXPECT_EQ(table.rows.front()[4].text, "drt-l");
}

TEST(SuiteTables, DifferencesHaveIntervalsAndSigns) {
  const SuiteReport report = someReport();
  const Table table = differenceTable(report.groups.front().comparisons, "slim");
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0][0].text, "drt-l");
  EXPECT_EQ(table.rows[0][1].text, "90");
  EXPECT_EQ(table.rows[0][2].text, "30");
  EXPECT_EQ(table.rows[0][3].text.rfind("-66.7 [", 0), 0u) << table.rows[0][3].text;
  EXPECT_TRUE(table.rows[0][3].best);
}

TEST(SuitePage, HoldsEveryTableAndTellsWhatFailed) {
  const SuiteReport report = someReport();
  const evaluation::Page page = suitePage(report);
  const std::string markdown = evaluation::pageMarkdown(page);
  for (const char* part :
       {"## Table I, accuracy: recorded motion", "## Table II, success rate",
        "## Table III, degenerate motion", "## Fig. 6, solve time", "## Differences to slim",
        "## Where slim is not first", "## Verdicts", "NOT RUN: recorded/V2_01: its imu0.csv",
        "- a note <here>", "not the same data"}) {
    EXPECT_NE(markdown.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(htmlProblem(evaluation::pageHtml(page, ".")), "");
  EXPECT_EQ(markdown.find("nan"), std::string::npos);
  EXPECT_NE(suiteText(report).find("Table III, degenerate motion"), std::string::npos);
}

}  // namespace
}  // namespace slim_init::tools
