// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The main tables of a run for a terminal. All others are made by the Python package in
// slim_init/evaluation/report.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "slim_init/evaluation/report.h"

namespace slim_init::evaluation {
namespace {

using Subset = SubsetSummary MethodSummary::*;

/// A figure of one method over one set of windows.
struct Column {
  const char* title;
  bool needs_truth;     ///< left out of the tables of a sequence without truth
  const char* pattern;  ///< of printf
  const char* key;
  double factor = 1.0;
};

constexpr Column kAccuracy[] = {{"success %", true, "%.1f", "success_rate", 100.0},
                                {"scale rmse", true, "%.4f", "scale_rmse"},
                                {"median", true, "%.4f", "scale_median"},
                                {"p90", true, "%.4f", "scale_p90"},
                                {"gravity deg", true, "%.3f", "gravity_rmse_deg"},
                                {"speed m/s", true, "%.4f", "velocity_rmse"},
                                {"velocity m/s", true, "%.4f", "velocity_vec_rmse"},
                                {"pose m", true, "%.4f", "pose_rmse"},
                                {"gyro bias %", true, "%.2f", "gyro_bias_err_pct"},
                                {"accepted", false, "%.0f", "accepted"},
                                {"|s-1|<0.1 %", true, "%.1f", "accepted_within_0_1_rate", 100.0},
                                {"solve ms", false, "%.3f", "solve_cpu_ms_median"}};
constexpr Column kFirstAnswer[] = {{"within 10 %, % of all", true, "%.1f", "right_rate", 100.0},
                                   {"beyond 25 %", true, "%.0f", "accepted_beyond_0_25"},
                                   {"largest", true, "%.3f", "accepted_scale_error_max"},
                                   {"time s, median", true, "%.2f", "right_s_median"},
                                   {"p90", true, "%.2f", "right_s_p90"},
                                   {"accepted %", false, "%.1f", "accepted_rate", 100.0},
                                   {"s, median", false, "%.2f", "accept_s_median"},
                                   {"p90", false, "%.2f", "accept_s_p90"},
                                   {"scale rmse", true, "%.4f", "accepted_scale_rmse"},
                                   {"error/sigma", true, "%.2f", "accepted_scale_over_sigma"}};

/// A dash for a number that does not exist.
std::string cellText(const Column& column, double value) {
  if (!std::isfinite(value)) return "-";
  char text[64];
  std::snprintf(text, sizeof(text), column.pattern, value);
  return text;
}

/// The title and a text per method.
std::vector<std::string> columnTexts(const Column& column,
                                     const std::vector<MethodSummary>& summaries, Subset subset) {
  std::vector<std::string> texts = {column.title};
  for (const MethodSummary& summary : summaries) {
    texts.push_back(cellText(column, column.factor * (summary.*subset).at(column.key)));
  }
  return texts;
}

template <std::size_t N>
std::string tableText(const Column (&columns)[N], const std::vector<MethodSummary>& summaries,
                      Subset subset, bool has_truth) {
  std::vector<std::string> lines = {"  method"};
  for (const MethodSummary& summary : summaries) lines.push_back("  " + summary.name);
  std::size_t width = 0;
  for (const std::string& line : lines) width = std::max(width, line.size());
  for (std::string& line : lines) line.resize(width, ' ');
  for (const Column& column : columns) {
    if (column.needs_truth && !has_truth) continue;
    const std::vector<std::string> texts = columnTexts(column, summaries, subset);
    width = 0;
    for (const std::string& text : texts) width = std::max(width, text.size());
    for (std::size_t i = 0; i < lines.size(); ++i) {
      lines[i] += std::string(2 + width - texts[i].size(), ' ') + texts[i];
    }
  }
  std::string table;
  for (const std::string& line : lines) table += line + "\n";
  return table;
}

std::string verdictText(const std::vector<MethodSummary>& summaries) {
  std::string text;
  std::size_t width = 0;
  for (const MethodSummary& summary : summaries) width = std::max(width, summary.name.size());
  for (const MethodSummary& summary : summaries) {
    text += "  " + summary.name + std::string(width - summary.name.size() + 2, ' ');
    const char* separator = "";
    for (const auto& [status, count] : summary.all.statuses) {
      text += separator + status + " " + std::to_string(count);
      separator = ", ";
    }
    text += "\n";
  }
  return text;
}

}  // namespace

std::string summaryTable(const ProtocolResult& result,
                         const std::vector<MethodSummary>& summaries) {
  std::string text;
  for (const Subset subset : {&MethodSummary::excited, &MethodSummary::all}) {
    const bool excited = subset == &MethodSummary::excited;
    const int windows =
        summaries.empty() ? 0 : static_cast<int>((summaries.front().*subset).at("windows"));
    text += (excited ? "" : "\n") + std::to_string(windows) + (excited ? " excited" : "") +
            (windows == 1 ? " window" : " windows") + (excited ? "" : " in all") + "\n";
    if (windows > 0) text += tableText(kAccuracy, summaries, subset, result.has_truth);
    if (windows > 0 && result.first_keyframes > 0) {
      text += "  First estimates, solved at every image; times of those within 10 %\n" +
              tableText(kFirstAnswer, summaries, subset, result.has_truth);
    }
  }
  return text + "\nStatuses, all windows\n" + verdictText(summaries);
}

}  // namespace slim_init::evaluation
