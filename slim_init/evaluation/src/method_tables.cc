// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/method_tables.h"

namespace slim_init::evaluation {
namespace {

using S = SubsetSummary;

bool shown(const SummaryColumn& column, bool has_truth) { return has_truth || !column.needs_truth; }

}  // namespace

const SummaryColumns& accuracyColumns() {
  static const SummaryColumns kColumns = {
      {"success %", true, Best::kHighest,
       [](const S& s) { return numberCell("%.1f", s.success_rate, 100.0); }},
      {"scale rmse", true, Best::kLowest,
       [](const S& s) { return numberCell("%.4f", s.scale_rmse); }},
      {"median", true, Best::kLowest,
       [](const S& s) { return numberCell("%.4f", s.scale_median); }},
      {"p90", true, Best::kLowest, [](const S& s) { return numberCell("%.4f", s.scale_p90); }},
      {"gravity deg", true, Best::kLowest,
       [](const S& s) { return numberCell("%.3f", s.gravity_rmse_deg); }},
      {"speed m/s", true, Best::kLowest,
       [](const S& s) { return numberCell("%.4f", s.velocity_rmse); }},
      {"velocity m/s", true, Best::kLowest,
       [](const S& s) { return numberCell("%.4f", s.velocity_vec_rmse); }},
      {"pose m", true, Best::kLowest, [](const S& s) { return numberCell("%.4f", s.pose_rmse); }},
      {"gyro bias %", true, Best::kLowest,
       [](const S& s) { return numberCell("%.2f", s.gyro_bias_err_pct); }},
      {"accepted", false, Best::kNone, [](const S& s) { return countCell(s.accepted); }},
      {"of them < 0.1 %", true, Best::kHighest,
       [](const S& s) { return numberCell("%.1f", s.accepted_within_0_1_rate, 100.0); }},
      {"solve ms", false, Best::kNone,
       [](const S& s) { return numberCell("%.3f", s.solve_cpu_ms_median); }},
  };
  return kColumns;
}

const SummaryColumns& acceptedColumns() {
  static const SummaryColumns kColumns = {
      {"accepted %", false, Best::kNone,
       [](const S& s) { return numberCell("%.1f", s.accepted_rate, 100.0); }},
      {"time to accept s, median", false, Best::kNone,
       [](const S& s) { return numberCell("%.2f", s.accept_s_median); }},
      {"p90", false, Best::kNone, [](const S& s) { return numberCell("%.2f", s.accept_s_p90); }},
      {"keyframes, median", false, Best::kNone,
       [](const S& s) { return numberCell("%.0f", s.accept_keyframes_median); }},
      {"scale rmse", true, Best::kLowest,
       [](const S& s) { return numberCell("%.4f", s.accepted_scale_rmse); }},
      {"median", true, Best::kLowest,
       [](const S& s) { return numberCell("%.4f", s.accepted_scale_median); }},
      {"largest", true, Best::kLowest,
       [](const S& s) { return numberCell("%.4f", s.accepted_scale_error_max); }},
      {"< 0.1 %", true, Best::kHighest,
       [](const S& s) { return numberCell("%.1f", s.accepted_within_0_1_rate, 100.0); }},
      {"< 0.5 %", true, Best::kHighest,
       [](const S& s) { return numberCell("%.1f", s.accepted_within_0_5_rate, 100.0); }},
      {"gravity deg", true, Best::kLowest,
       [](const S& s) { return numberCell("%.3f", s.accepted_gravity_rmse_deg); }},
      {"speed m/s", true, Best::kLowest,
       [](const S& s) { return numberCell("%.4f", s.accepted_velocity_rmse); }},
  };
  return kColumns;
}

const SummaryColumns& downstreamColumns() {
  static const SummaryColumns kColumns = {
      {"runs", false, Best::kNone, [](const S& s) { return countCell(s.downstream_runs); }},
      {"diverged %", false, Best::kLowest,
       [](const S& s) { return numberCell("%.1f", s.downstream_divergence_rate, 100.0); }},
      {"ATE m, median", true, Best::kLowest,
       [](const S& s) { return numberCell("%.3f", s.downstream_ate_median); }},
      {"p90", true, Best::kLowest,
       [](const S& s) { return numberCell("%.3f", s.downstream_ate_p90); }},
      {"final scale error, median", true, Best::kLowest,
       [](const S& s) { return numberCell("%.4f", s.downstream_scale_median); }},
      {"p90", true, Best::kLowest,
       [](const S& s) { return numberCell("%.4f", s.downstream_scale_p90); }},
  };
  return kColumns;
}

const SummaryColumns& timeColumns() {
  static const SummaryColumns kColumns = {
      {"windows", false, Best::kNone, [](const S& s) { return countCell(s.attempted); }},
      {"CPU ms, median", false, Best::kLowest,
       [](const S& s) { return numberCell("%.3f", s.solve_cpu_ms_median); }},
      {"mean", false, Best::kLowest,
       [](const S& s) { return numberCell("%.3f", s.solve_cpu_ms_mean); }},
      {"p90", false, Best::kLowest,
       [](const S& s) { return numberCell("%.3f", s.solve_cpu_ms_p90); }},
      {"wall ms, median", false, Best::kNone,
       [](const S& s) { return numberCell("%.3f", s.solve_ms_median); }},
  };
  return kColumns;
}

const SummaryColumns& verdictColumns() {
  static const SummaryColumns kColumns = {
      {"windows", false, Best::kNone, [](const S& s) { return countCell(s.windows); }},
      {"with estimate", false, Best::kNone, [](const S& s) { return countCell(s.attempted); }},
      {"success", true, Best::kNone, [](const S& s) { return countCell(s.success); }},
      {"accepted", false, Best::kNone, [](const S& s) { return countCell(s.accepted); }},
      {"waiting", false, Best::kNone, [](const S& s) { return countCell(s.waiting); }},
      {"refused", false, Best::kNone, [](const S& s) { return countCell(s.refused); }},
      {"failed", false, Best::kNone, [](const S& s) { return countCell(s.failed); }},
      {"accepted < 0.1 off", true, Best::kNone,
       [](const S& s) { return countCell(s.accepted_within_0_1); }},
      {"accepted >= 0.5 off", true, Best::kNone,
       [](const S& s) { return countCell(s.accepted - s.accepted_within_0_5); }},
      {"largest accepted error", true, Best::kNone,
       [](const S& s) { return numberCell("%.3f", s.accepted_scale_error_max); }},
  };
  return kColumns;
}

Table emptyTable(const std::vector<std::string>& names, const SummaryColumns& columns,
                 bool has_truth) {
  Table table;
  table.columns = names;
  table.text_columns = names.size();
  for (const SummaryColumn& column : columns) {
    if (shown(column, has_truth)) table.columns.push_back(column.title);
  }
  return table;
}

void addMethods(const std::vector<std::string>& names, const SummaryColumns& columns,
                const std::vector<MethodSummary>& summaries, SubsetOf subset, bool has_truth,
                Table* table) {
  const std::size_t first = table->rows.size();
  for (const MethodSummary& summary : summaries) {
    std::vector<TableCell> row(names.begin(), names.end());
    row.emplace_back(summary.name);
    for (const SummaryColumn& column : columns) {
      if (shown(column, has_truth)) row.push_back(column.cell(summary.*subset));
    }
    table->rows.push_back(std::move(row));
  }
  std::size_t c = names.size() + 1;
  for (const SummaryColumn& column : columns) {
    if (shown(column, has_truth)) markBest(column.best, c++, first, table->rows.size(), table);
  }
}

Table methodTable(const SummaryColumns& columns, const std::vector<MethodSummary>& summaries,
                  SubsetOf subset, bool has_truth) {
  Table table = emptyTable({"method"}, columns, has_truth);
  addMethods({}, columns, summaries, subset, has_truth, &table);
  return table;
}

}  // namespace slim_init::evaluation
