// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "evaluation/scratch_folder.h"
#include "support/csv.h"
#include "support/text_parts.h"

namespace slim_init::evaluation {
namespace {

MethodRecord record(InitStatus status, bool attempted, double scale, double solve_ms) {
  MethodRecord r;
  r.answer.status = status;
  r.answer.message = "said so";
  r.answer.states.resize(attempted ? 1 : 0);
  r.solve_ms = solve_ms;
  r.solve_cpu_ms = 0.5 * solve_ms;
  if (!attempted) {
    r.metrics.failure = "no estimate";
    return r;
  }
  r.metrics.scale = scale;
  r.metrics.scale_error = std::abs(scale - 1.0);
  r.metrics.gravity_error_deg = 10.0 * r.metrics.scale_error;
  r.metrics.velocity_rmse = 2.0 * r.metrics.scale_error;
  r.metrics.velocity_vec_rmse = 3.0 * r.metrics.scale_error;
  r.metrics.pose_rmse = 4.0 * r.metrics.scale_error;
  r.metrics.gyro_bias_err_pct = 50.0 * r.metrics.scale_error;
  r.metrics.gyro_bias_vec_err = 0.1 * r.metrics.scale_error;
  return r;
}

/// Five windows of one method, numbers chosen by hand; the last two are not excited.
ProtocolResult handMade() {
  ProtocolResult result;
  result.methods = {"hand"};
  const std::vector<MethodRecord> records = {
      record(InitStatus::kSuccess, true, 1.03, 1.0),
      record(InitStatus::kSuccess, true, 0.6, 2.0),             // |s-1| = 0.4
      record(InitStatus::kScaleTooUncertain, true, 0.96, 3.0),  // refused, yet a success
      record(InitStatus::kSuccess, true, 1.7, 10.0),            // accepted, yet wrong
      record(InitStatus::kTooFewTracks, false, 0.0, 99.0),
  };
  for (std::size_t i = 0; i < records.size(); ++i) {
    WindowRecord window;
    window.trial = static_cast<int>(i);
    window.t_start = 0.5 * static_cast<double>(i);
    window.t_start_ns = 1403715523912143104 + 500000000LL * static_cast<int>(i);
    window.duration_s = 2.25;
    window.keyframes = 10;
    window.excitation.excited = i < 3;
    window.excitation.mean_deviation = 0.01;
    window.methods = {records[i]};
    result.windows.push_back(window);
  }
  result.counts.frames = 100;
  result.counts.trials = 10;
  result.counts.windows = 5;
  result.counts.ended = 5;
  return result;
}

RunInfo someRun() {
  RunInfo info;
  info.dataset = "V9_99";
  info.command = "slim_init ab --something";
  info.gyro_bias_truth = "fitted";
  info.options = {{"seed", OptionValue(std::int64_t{7})},
                  {"pixel_noise", OptionValue(0.6)},
                  {"world", OptionValue(std::string("room"))},
                  {"methods", OptionValue(std::vector<std::string>{"hand"})}};
  info.notes = {"a note"};
  return info;
}

nlohmann::json jsonOf(const ProtocolResult& result, const RunInfo& info = someRun()) {
  return nlohmann::json::parse(summaryJson(info, result, summarize(result)));
}

TEST(Summary, StatisticsByHand) {
  const std::vector<MethodSummary> summaries = summarize(handMade());
  ASSERT_EQ(summaries.size(), 1u);
  EXPECT_EQ(summaries[0].name, "hand");
  const SubsetSummary& all = summaries[0].all;
  EXPECT_EQ(all.at("windows"), 5);
  EXPECT_EQ(all.at("attempted"), 4);
  EXPECT_EQ(all.at("success"), 3);
  EXPECT_DOUBLE_EQ(all.at("success_rate"), 0.6);
  const double mean_square = (0.03 * 0.03 + 0.4 * 0.4 + 0.04 * 0.04) / 3.0;
  EXPECT_NEAR(all.at("scale_rmse"), std::sqrt(mean_square), 1e-12);
  EXPECT_NEAR(all.at("scale_median"), 0.04, 1e-12);
  // Sorted 0.03, 0.04, 0.4: position 1.8.
  EXPECT_NEAR(all.at("scale_p90"), 0.2 * 0.04 + 0.8 * 0.4, 1e-12);
  EXPECT_NEAR(all.at("gravity_rmse_deg"), 10.0 * std::sqrt(mean_square), 1e-11);
  EXPECT_NEAR(all.at("velocity_rmse"), 2.0 * std::sqrt(mean_square), 1e-12);
  EXPECT_NEAR(all.at("velocity_vec_rmse"), 3.0 * std::sqrt(mean_square), 1e-12);
  EXPECT_NEAR(all.at("pose_rmse"), 4.0 * std::sqrt(mean_square), 1e-12);
  EXPECT_NEAR(all.at("gyro_bias_err_pct"), 50.0 * std::sqrt(mean_square), 1e-11);
  EXPECT_EQ(all.at("accepted"), 3);
  EXPECT_NEAR(all.at("accepted_within_0_1_rate"), 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(all.at("accepted_scale_error_max"), 0.7, 1e-12);
  EXPECT_EQ(all.statuses.at("success"), 3);
  EXPECT_EQ(all.statuses.at("scale_too_uncertain"), 1);
  EXPECT_EQ(all.statuses.at("too_few_tracks"), 1);
  const std::string text = summaryTable(handMade(), summaries);
  expectParts(text, "hand  scale_too_uncertain 1, success 3, too_few_tracks 1");
  // The window without an estimate (99 ms) does not count as a solve.
  EXPECT_DOUBLE_EQ(all.at("solve_cpu_ms_median"), 1.25);

  const SubsetSummary& excited = summaries[0].excited;
  EXPECT_EQ(excited.at("windows"), 3);
  EXPECT_EQ(excited.at("success"), 3);
  EXPECT_DOUBLE_EQ(excited.at("success_rate"), 1.0);
  EXPECT_EQ(excited.at("accepted"), 2);
}

TEST(Summary, FailedWindowsNeverReachAMean) {
  ProtocolResult result = handMade();
  MethodRecord& broken = result.windows[0].methods[0];
  broken.metrics = WindowMetrics();
  broken.metrics.failure = "estimate at keyframe 3 is not finite";
  const SubsetSummary all = summarize(result)[0].all;
  EXPECT_EQ(all.at("attempted"), 4);
  EXPECT_EQ(all.at("success"), 2);
  EXPECT_EQ(all.at("accepted"), 3);
  EXPECT_EQ(all.at("accepted_within_0_1_rate"), 0.0);
  EXPECT_TRUE(std::isfinite(all.at("scale_rmse")));
}

TEST(Summary, NumbersThatDoNotExistAreNull) {
  ProtocolResult result;
  result.methods = {"none"};
  WindowRecord window;
  window.methods = {record(InitStatus::kTooFewTracks, false, 0.0, 1.0)};
  result.windows = {window};
  const std::vector<MethodSummary> summaries = summarize(result);
  EXPECT_EQ(summaries[0].all.at("success_rate"), 0.0);
  const std::string text = summaryJson(someRun(), result, summaries);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  const auto json = nlohmann::json::parse(text);
  const auto& all = json["methods"]["none"]["all"];
  EXPECT_EQ(all["windows"], 1);
  EXPECT_EQ(all["attempted"], 0);
  EXPECT_EQ(all["success_rate"], 0.0);
  for (const char* key :
       {"scale_rmse", "scale_median", "gravity_rmse_deg", "velocity_rmse", "velocity_vec_rmse",
        "pose_rmse", "gyro_bias_err_pct", "accepted_within_0_1_rate", "solve_cpu_ms_median"}) {
    EXPECT_TRUE(all[key].is_null()) << key;
  }
  const auto& excited = json["methods"]["none"]["excited"];
  EXPECT_EQ(excited["windows"], 0);
  EXPECT_TRUE(excited["success_rate"].is_null());
  // The other texts have empty fields and dashes.
  EXPECT_EQ(windowsCsv(someRun(), result).find("nan"), std::string::npos);
  EXPECT_EQ(summaryTable(result, summaries).find("nan"), std::string::npos);
  EXPECT_NE(summaryTable(result, summaries).find(" - "), std::string::npos);
}

TEST(SummaryJson, SaysWhatWasRun) {
  const auto json = jsonOf(handMade());
  EXPECT_EQ(json["dataset"], "V9_99");
  EXPECT_EQ(json["command"], "slim_init ab --something");
  EXPECT_EQ(json["gyro_bias_truth"], "fitted");
  EXPECT_EQ(json["options"]["seed"], 7);
  EXPECT_EQ(json["options"]["pixel_noise"], 0.6);
  EXPECT_EQ(json["options"]["world"], "room");
  EXPECT_EQ(json["options"]["methods"][0], "hand");
  EXPECT_EQ(json["notes"][0], "a note");
  EXPECT_EQ(json["trials"]["ended"], 5);
  for (const char* subset : {"all", "excited"}) {
    const auto& object = json["methods"]["hand"][subset];
    EXPECT_EQ(object["statuses"]["success"], std::string(subset) == "all" ? 3 : 2);
  }
}

TEST(SummaryJson, SurvivesBytesThatAreNoText) {
  RunInfo info = someRun();
  info.dataset = "bad\xff\"name";
  const auto json = jsonOf(handMade(), info);
  expectParts(json["dataset"], "\"name");
}

using Fields = std::map<std::string, std::string>;

void expectFields(const Fields& row, const Fields& expected) {
  for (const auto& [column, value] : expected) EXPECT_EQ(row.at(column), value) << column;
}

TEST(WindowsCsv, OneRowPerWindowAndMethodWithQuoting) {
  ProtocolResult result = handMade();
  result.methods.emplace_back("second");
  for (WindowRecord& window : result.windows) {
    window.methods.push_back(record(InitStatus::kSuccess, true, 1.0, 5.0));
  }
  MethodRecord& first = result.windows[0].methods[0];
  first.answer.scale_sigma = 0.25;
  first.answer.gates.resize(2);
  first.answer.gates[0].name = GateName::kScaleSigma;
  first.answer.gates[0].value = 0.25;
  first.answer.gates[1].name = GateName::kLinkage;
  first.answer.stages = {{"gyro_bias", 0.5}, {"ligt", 0.25}};
  const std::string csv = windowsCsv(someRun(), result);
  const auto rows = csvRows(csv);
  ASSERT_EQ(rows.size(), 10u);
  expectFields(rows[0], {{"message", "said so"},
                         {"gates", "scale_sigma=0.25;linkage="},
                         {"stages_ms", "gyro_bias=0.5;ligt=0.25"},
                         {"t_start_ns", "1403715523912143104"},
                         {"method", "hand"},
                         {"status", "success"},
                         {"scale", "1.03"},
                         {"excited", "1"},
                         {"solve_ms", "1"},
                         {"solve_cpu_ms", "0.5"}});
  expectFields(rows[1], {{"method", "second"}});
  expectFields(rows[4], {{"status", "scale_too_uncertain"}, {"success", "1"}});
  expectFields(rows[6], {{"success", "0"}});
  expectFields(
      rows[8],
      {{"attempted", "0"}, {"scale", ""}, {"excited", "0"}, {"not_evaluated", "no estimate"}});
  // What a clock says comes last, so that it can be cut off.
  expectParts(csv, ",solve_cpu_ms,solve_ms,stages_ms\n");
  first.answer.message = "he said \"no\", twice,\nand left";
  expectParts(windowsCsv(someRun(), result), ",\"he said \"\"no\"\", twice,\nand left\",");
}

TEST(Report, FailureToWriteIsASentence) {
  const ScratchFolder folder;
  folder.write("file", "in the way");
  const ProtocolResult result = handMade();
  std::string error = writeReport(folder.file("file"), someRun(), result, summarize(result));
  expectParts(error, "file cannot be made");
  // A folder where a file should go works even for root, whom no permission stops.
  std::filesystem::create_directories(folder.file("out/summary.json"));
  error = writeReport(folder.file("out"), someRun(), result, summarize(result));
  expectParts(error, "summary.json cannot be written");
}

TEST(Report, SummaryKeepsProgramNotesAndRefusals) {
  RunInfo info = someRun();
  info.version = "9.8.7";
  ProtocolResult result = handMade();
  auto json = jsonOf(result, info);
  EXPECT_EQ(json["version"], "9.8.7");
  EXPECT_TRUE(json["commit"].is_null());
  EXPECT_FALSE(json.contains("method_notes"));
  EXPECT_FALSE(json.contains("first_refusal"));
  info.commit = "0123abcd";
  info.method_notes = {{"hand[less]", "with less"}};
  result.first_refusal = "times go back";
  result.dropped.imu[AddStatus::kOutOfOrder] = 3;
  json = jsonOf(result, info);
  EXPECT_EQ(json["commit"], "0123abcd");
  EXPECT_EQ(json["method_notes"]["hand[less]"], "with less");
  EXPECT_EQ(json["first_refusal"], "times go back");
  EXPECT_EQ(json["dropped"]["imu_out_of_order"], 3);
  EXPECT_EQ(json["dropped"]["imu_not_finite"], 0);
}

TEST(Report, AcceptedAnswersHaveErrorsOfTheirOwn) {
  ProtocolResult result = handMade();
  result.first_keyframes = 4;
  for (std::size_t i = 0; i < result.windows.size(); ++i) {
    MethodRecord& answer = result.windows[i].methods[0];
    answer.keyframes = 4 + static_cast<int>(i);
    answer.data_s = 0.75 + 0.25 * static_cast<double>(i);
  }
  const SubsetSummary all = summarize(result)[0].all;
  // Windows 0, 1 and 3 are accepted, with |s-1| of 0.03, 0.4 and 0.7.
  EXPECT_DOUBLE_EQ(all.at("accepted_rate"), 0.6);
  EXPECT_NEAR(all.at("accepted_scale_rmse"), std::sqrt((0.03 * 0.03 + 0.4 * 0.4 + 0.7 * 0.7) / 3.0),
              1e-12);
  EXPECT_NEAR(all.at("accept_s_median"), 1.0, 1e-12);
  EXPECT_NEAR(all.at("accept_s_p90"), 0.2 * 1.0 + 0.8 * 1.5, 1e-12);  // sorted 0.75, 1.0, 1.5
  const auto rows = csvRows(windowsCsv(someRun(), result));
  expectFields(rows[1], {{"answer_keyframes", "5"}, {"answer_s", "1"}, {"keyframes", "10"}});
}

TEST(Report, WithoutTruthThereAreNoErrorColumns) {
  ProtocolResult result = handMade();
  result.has_truth = false;
  for (WindowRecord& window : result.windows) {
    window.methods[0].metrics = WindowMetrics();
    window.methods[0].metrics.failure = "no ground truth";
    window.methods[0].calibration.td_s = 0.002;  // against the configured one
  }
  const std::vector<MethodSummary> summaries = summarize(result);
  EXPECT_NEAR(summaries[0].all.at("accepted_td_rmse_ms"), 2.0, 1e-9);
  EXPECT_TRUE(std::isnan(summaries[0].all.at("success_rate")));
  EXPECT_EQ(summaries[0].all.at("accepted"), 3);
  const std::string text = summaryTable(result, summaries);
  EXPECT_EQ(text.find("scale rmse"), std::string::npos) << text;
  EXPECT_NE(text.find("accepted"), std::string::npos) << text;
  const auto json = jsonOf(result);
  EXPECT_EQ(json["has_truth"], false);
  EXPECT_TRUE(json["methods"]["hand"]["all"]["success_rate"].is_null());
}

TEST(WindowsCsv, AnAnswerWithoutStatesHasItsGravityAndBias) {
  ProtocolResult result = handMade();
  MethodRecord& answer = result.windows[1].methods[0];
  answer = record(InitStatus::kStationary, false, 0.0, 1.0);
  answer.metrics.gravity_error_deg = 1.5;
  answer.metrics.gyro_bias_vec_err = 0.001;
  const auto rows = csvRows(windowsCsv(someRun(), result));
  expectFields(rows[1],
               {{"gravity_error_deg", "1.5"}, {"gyro_bias_vec_err", "0.001"}, {"scale_error", ""}});
}

TEST(Report, TellsWhatTheFrontEndDid) {
  RunInfo info = someRun();
  info.tracking.emplace();
  info.tracking->images = 70;
  info.tracking->tracked = 65;
  info.tracking->unreadable = 5;
  info.tracking->points = 123.0;
  info.tracking->lines_carried = 45.0;
  info.tracking->total_ms_median = 6.25;
  info.simulated = {{"outlier_tracks", 17}};
  const auto json = jsonOf(handMade(), info);
  const std::map<std::string, double> expected = {
      {"images", 70},    {"tracked", 65},         {"unreadable", 5},
      {"points", 123.0}, {"lines_carried", 45.0}, {"total_ms_median", 6.25}};
  for (const auto& [key, value] : expected) EXPECT_EQ(json["tracking"][key], value) << key;
  EXPECT_TRUE(json["tracking"]["lines"].is_null());
  EXPECT_EQ(json["simulated"]["outlier_tracks"], 17);
}

/// The line of the terminal's main table (all windows) that begins with the name.
std::string tableLine(const std::string& text, const std::string& name) {
  const std::size_t block = text.find("in all\n");
  const std::size_t begin = text.find("\n  " + name, block) + 1;
  return text.substr(begin, text.find('\n', begin) - begin);
}

TEST(Report, TheTerminalTableIsAligned) {
  ProtocolResult result = handMade();
  result.methods = {"hand", "better", "none"};
  for (WindowRecord& window : result.windows) {
    window.methods.push_back(record(InitStatus::kSuccess, true, 1.01, 5.0));
    window.methods.push_back(record(InitStatus::kTooFewTracks, false, 0.0, 1.0));
  }
  const std::string text = summaryTable(result, summarize(result));
  EXPECT_EQ(tableLine(text, "method").find("  method  success %  scale rmse  "), 0u) << text;
  EXPECT_EQ(tableLine(text, "hand").find("  hand         60.0      0.2327  "), 0u) << text;
  EXPECT_EQ(tableLine(text, "better").find("  better      100.0      0.0100  "), 0u) << text;
  EXPECT_EQ(tableLine(text, "none").find("  none          0.0           -  "), 0u) << text;
  EXPECT_EQ(tableLine(text, "hand").size(), tableLine(text, "method").size());
}

}  // namespace
}  // namespace slim_init::evaluation
