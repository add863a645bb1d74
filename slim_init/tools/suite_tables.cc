// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "suite_tables.h"

#include <algorithm>
#include <cmath>

#include "paper_figures.h"

namespace slim_init::tools {
namespace {

using evaluation::Best;
using evaluation::Comparison;
using evaluation::countCell;
using evaluation::Interval;
using evaluation::MethodSummary;
using evaluation::numberCell;
using evaluation::SubsetOf;
using evaluation::SubsetSummary;
using evaluation::SummaryColumns;
using evaluation::Table;
using evaluation::TableCell;

/// An error of the paper's tables.
struct ErrorMetric {
  PaperMetric paper;
  const char* title;
  const char* pattern;
  double SubsetSummary::*rmse;
};
constexpr ErrorMetric kErrors[] = {
    {PaperMetric::kScale, "Scale RMSE", "%.3f", &SubsetSummary::scale_rmse},
    {PaperMetric::kGravityDeg, "Gravity direction RMSE [deg]", "%.3f",
     &SubsetSummary::gravity_rmse_deg},
    {PaperMetric::kVelocity, "Velocity RMSE [m/s] (difference of speeds)", "%.3f",
     &SubsetSummary::velocity_rmse},
    {PaperMetric::kPose, "Pose RMSE [m]", "%.4f", &SubsetSummary::pose_rmse}};

constexpr char kFewWindows[] = "\xE2\x80\xA0";  // a dagger

/// A root mean square over the successful windows, marked where those are few.
TableCell errorCell(const SubsetSummary& s, double SubsetSummary::*field,
                    const char* pattern = "%.3f") {
  TableCell cell = numberCell(pattern, s.*field);
  if (std::isfinite(cell.value) && 2 * s.success < s.windows) cell.text += kFewWindows;
  return cell;
}

TableCell successCell(const SubsetSummary& s) { return numberCell("%.1f", s.success_rate, 100.0); }

void setBeside(const char* pattern, double printed, TableCell* cell) {
  if (std::isfinite(printed)) cell->beside = numberCell(pattern, printed).text;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? kNotComputed : sum / static_cast<double>(values.size());
}

/// Methods in the order in which the cases name them.
std::vector<std::string> methodsOf(const SuiteResults& results) {
  std::vector<std::string> names;
  for (const SuiteResult* result : results) {
    for (const MethodSummary& summary : result->run.summaries) {
      if (std::find(names.begin(), names.end(), summary.name) == names.end()) {
        names.push_back(summary.name);
      }
    }
  }
  return names;
}

const MethodSummary* find(const std::vector<MethodSummary>& summaries, const std::string& name) {
  const auto found = std::find_if(summaries.begin(), summaries.end(),
                                  [&](const MethodSummary& s) { return s.name == name; });
  return found == summaries.end() ? nullptr : &*found;
}

Table accuracyTable(const ErrorMetric& metric, const SuiteResults& results, SubsetOf subset) {
  Table table;
  table.title = metric.title;
  table.columns = {"method"};
  for (const SuiteResult* result : results) table.columns.push_back(result->entry.name);
  table.columns.emplace_back("mean");
  for (const std::string& method : methodsOf(results)) {
    std::vector<TableCell> row = {method};
    std::vector<double> measured;
    std::vector<double> printed;
    for (const SuiteResult* result : results) {
      const MethodSummary* summary = find(result->run.summaries, method);
      row.push_back(summary == nullptr ? TableCell("-")
                                       : errorCell(summary->*subset, metric.rmse, metric.pattern));
      const double paper = paperAccuracy(metric.paper, method, result->entry.paper_column);
      setBeside("%.3f", paper, &row.back());
      if (std::isfinite(row.back().value)) measured.push_back(row.back().value);
      if (std::isfinite(paper)) printed.push_back(paper);
    }
    // Over the sequences shown, or not at all: means over different ones do not compare.
    row.push_back(numberCell(metric.pattern,
                             measured.size() == results.size() ? mean(measured) : kNotComputed));
    setBeside("%.3f", printed.size() == results.size() ? mean(printed) : kNotComputed, &row.back());
    table.rows.push_back(std::move(row));
  }
  for (std::size_t c = 1; c < table.columns.size(); ++c) {
    markBest(Best::kLowest, c, 0, table.rows.size(), &table);
  }
  return table;
}

/// The errors of one row of tables III and IV.
void addErrors(const SubsetSummary& s, const char* tool_name,
               double (*paper)(PaperMetric, const std::string&), std::vector<TableCell>* row) {
  for (const ErrorMetric& metric : kErrors) {
    row->push_back(errorCell(s, metric.rmse, metric.pattern));
    if (paper != nullptr) setBeside("%.3f", paper(metric.paper, tool_name), &row->back());
  }
}

const std::vector<std::string>& errorTitles() {
  static const std::vector<std::string> kTitles = {"scale", "gravity deg", "velocity m/s",
                                                   "pose m"};
  return kTitles;
}

std::string intervalText(const char* pattern, const Interval& interval, double factor) {
  const std::string value = numberCell(pattern, interval.value, factor).text;
  if (!std::isfinite(interval.low) || !std::isfinite(interval.high)) return value;
  return value + " [" + numberCell(pattern, interval.low, factor).text + ", " +
         numberCell(pattern, interval.high, factor).text + "]";
}

/// Bold where zero is outside the interval.
TableCell intervalCell(const char* pattern, const Interval& interval, double factor = 1.0) {
  TableCell cell(intervalText(pattern, interval, factor));
  cell.best = interval.significant();
  return cell;
}

const SummaryColumns& detailColumns() {
  using S = SubsetSummary;
  static const SummaryColumns kColumns = {
      {"windows", false, Best::kNone, [](const S& s) { return countCell(s.windows); }},
      {"success %", true, Best::kHighest, successCell},
      {"scale rmse", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::scale_rmse, "%.4f"); }},
      {"scale median", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::scale_median, "%.4f"); }},
      {"scale p90", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::scale_p90, "%.4f"); }},
      {"gravity deg rmse", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::gravity_rmse_deg); }},
      {"gravity median", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::gravity_median_deg); }},
      {"gravity p90", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::gravity_p90_deg); }},
      {"velocity m/s rmse", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::velocity_rmse, "%.4f"); }},
      {"velocity median", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::velocity_median, "%.4f"); }},
      {"velocity p90", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::velocity_p90, "%.4f"); }},
      {"pose m rmse", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::pose_rmse, "%.4f"); }},
      {"pose median", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::pose_median, "%.4f"); }},
      {"pose p90", true, Best::kLowest,
       [](const S& s) { return errorCell(s, &S::pose_p90, "%.4f"); }}};
  return kColumns;
}

}  // namespace

std::vector<const evaluation::ProtocolResult*> protocolResults(const SuiteResults& results) {
  std::vector<const evaluation::ProtocolResult*> list;
  for (const SuiteResult* result : results) list.push_back(&result->run.result);
  return list;
}

Table caseTable(const SuiteResults& results) {
  Table table;
  table.columns = {"case",    "group",   "features",      "truth of the gyro bias", "trials",
                   "windows", "excited", "not evaluated", "notes on the data"};
  table.text_columns = 4;
  for (const SuiteResult* result : results) {
    const evaluation::ProtocolResult& run = result->run.result;
    const auto excited =
        std::count_if(run.windows.begin(), run.windows.end(),
                      [](const evaluation::WindowRecord& w) { return w.excitation.excited; });
    table.rows.push_back({result->entry.folder(), result->entry.group, result->entry.feature(),
                          result->run.info.gyro_bias_truth, countCell(run.counts.trials),
                          countCell(run.counts.windows), countCell(excited),
                          countCell(run.counts.trials - run.counts.windows),
                          countCell(static_cast<long long>(result->run.info.notes.size()))});
  }
  return table;
}

std::vector<Table> accuracyTables(const SuiteResults& results, SubsetOf subset) {
  std::vector<Table> tables;
  for (const ErrorMetric& metric : kErrors) {
    tables.push_back(accuracyTable(metric, results, subset));
  }
  return tables;
}

Table caseMethodTable(const SuiteResults& results, const SummaryColumns& columns, SubsetOf subset) {
  Table table = evaluation::emptyTable({"case", "method"}, columns);
  for (const SuiteResult* result : results) {
    // One table for all: without truth the figures are dashes.
    evaluation::addMethods({result->entry.name}, columns, result->run.summaries, subset, true,
                           &table);
  }
  return table;
}

Table detailTable(const SuiteResults& results, SubsetOf subset) {
  return caseMethodTable(results, detailColumns(), subset);
}

Table successTable(const SuiteResults& results, SubsetOf subset) {
  std::vector<std::string> groups;
  for (const SuiteResult* result : results) {
    if (std::find(groups.begin(), groups.end(), result->entry.group) == groups.end()) {
      groups.push_back(result->entry.group);
    }
  }
  Table table;
  table.columns = {"method"};
  for (const std::string& method : methodsOf(results)) table.rows.push_back({method});
  for (const std::string& group : groups) {
    SuiteResults members;
    std::string names;
    std::copy_if(results.begin(), results.end(), std::back_inserter(members),
                 [&](const SuiteResult* result) { return result->entry.group == group; });
    for (const SuiteResult* member : members) {
      names += (names.empty() ? "" : ", ") + member->entry.name;
    }
    table.columns.push_back(group + " (" + names + ")");
    const std::vector<MethodSummary> pooled = evaluation::summarize(protocolResults(members));
    for (auto& row : table.rows) {
      const MethodSummary* summary = find(pooled, row.front().text);
      row.push_back(summary == nullptr ? TableCell("-") : successCell(summary->*subset));
      setBeside("%.1f", paperSuccess(row.front().text, group), &row.back());
    }
  }
  for (std::size_t c = 1; c < table.columns.size(); ++c) {
    markBest(Best::kHighest, c, 0, table.rows.size(), &table);
  }
  return table;
}

Table degenerateTable(const SuiteResults& results) {
  Table table;
  table.columns = {"case", "method", "success %"};
  table.columns.insert(table.columns.end(), errorTitles().begin(), errorTitles().end());
  table.columns.insert(table.columns.end(), {"accepted", "accepted >= 0.5 off"});
  table.text_columns = 2;
  for (const SuiteResult* result : results) {
    const bool walk = result->entry.options.builtin == "corridor-walk";
    const std::size_t first = table.rows.size();
    for (const MethodSummary& summary : result->run.summaries) {
      const SubsetSummary& s = summary.all;
      std::vector<TableCell> row = {result->entry.name, summary.name, successCell(s)};
      addErrors(s, summary.name.c_str(), walk ? paperDegenerate : nullptr, &row);
      row.push_back(countCell(s.accepted));
      row.push_back(countCell(s.accepted - s.accepted_within_0_5));
      table.rows.push_back(std::move(row));
    }
    for (std::size_t c = 2; c < 3 + errorTitles().size(); ++c) {
      markBest(c == 2 ? Best::kHighest : Best::kLowest, c, first, table.rows.size(), &table);
    }
  }
  return table;
}

Table ablationTable(const SuiteResults& results, bool degenerate) {
  Table table;
  table.columns = {"variant", "what is changed", "success %"};
  table.columns.insert(table.columns.end(), errorTitles().begin(), errorTitles().end());
  table.columns.insert(table.columns.end(), {"gyro bias %", "accepted", "CPU ms, median"});
  table.text_columns = 2;
  if (results.empty()) return table;
  const auto& notes = results.front()->run.info.method_notes;
  std::size_t first = 0;
  std::string before;
  const auto markBlock = [&] {
    for (std::size_t c = 2; c < 4 + errorTitles().size(); ++c) {
      markBest(c == 2 ? Best::kHighest : Best::kLowest, c, first, table.rows.size(), &table);
    }
    first = table.rows.size();
  };
  for (const MethodSummary& summary : evaluation::summarize(protocolResults(results))) {
    const std::string base = summary.name.substr(0, summary.name.find('['));
    if (base != before) markBlock();
    before = base;
    const auto note = std::find_if(notes.begin(), notes.end(),
                                   [&](const auto& known) { return known.first == summary.name; });
    const SubsetSummary& s = summary.all;
    std::vector<TableCell> row = {summary.name, note == notes.end() ? "" : note->second,
                                  successCell(s)};
    addErrors(s, summary.name.c_str(), degenerate ? paperAblation : nullptr, &row);
    row.push_back(numberCell("%.3f", s.gyro_bias_err_pct));
    if (!degenerate) setBeside("%.3f", paperGyroBiasPct(summary.name), &row.back());
    row.push_back(countCell(s.accepted));
    row.push_back(numberCell("%.3f", s.solve_cpu_ms_median));
    table.rows.push_back(std::move(row));
  }
  markBlock();
  return table;
}

Table timeTable(const SuiteResults& results) {
  Table table = evaluation::emptyTable({"method"}, evaluation::timeColumns());
  evaluation::addMethods({}, evaluation::timeColumns(),
                         evaluation::summarize(protocolResults(results)), &MethodSummary::all, true,
                         &table);
  const auto mean_column = std::find(table.columns.begin(), table.columns.end(), "mean");
  for (auto& row : table.rows) {
    setBeside("%.3f", paperSolveMs(row.front().text),
              &row[static_cast<std::size_t>(mean_column - table.columns.begin())]);
  }
  return table;
}

Table differenceTable(const std::vector<Comparison>& comparisons, const std::string& reference) {
  Table table;
  table.columns = {"method minus " + reference,
                   "windows",
                   "both succeed",
                   "success %",
                   "scale rmse",
                   "gravity deg",
                   "velocity m/s",
                   "pose m"};
  for (const Comparison& c : comparisons) {
    table.rows.push_back(
        {c.method, countCell(c.windows), countCell(c.both_success),
         intervalCell("%+.1f", c.success_rate, 100.0), intervalCell("%+.3f", c.scale_rmse),
         intervalCell("%+.2f", c.gravity_rmse_deg), intervalCell("%+.3f", c.velocity_rmse),
         intervalCell("%+.3f", c.pose_rmse)});
  }
  return table;
}

Table notFirstTable(const Table& table, const std::string& method, int* figures) {
  Table list;
  list.columns = {"case", "figure", method, "best", "of"};
  list.text_columns = 2;
  *figures = 0;
  for (std::size_t first = 0; first < table.rows.size();) {
    // The rows of one case.
    std::size_t end = first;
    std::size_t own = table.rows.size();
    while (end < table.rows.size() && table.rows[end][0].text == table.rows[first][0].text) {
      if (table.rows[end][1].text == method) own = end;
      ++end;
    }
    for (std::size_t c = table.text_columns; own < end && c < table.columns.size(); ++c) {
      for (std::size_t r = first; r < end; ++r) {
        if (!table.rows[r][c].best) continue;
        ++*figures;
        if (table.rows[own][c].best) break;
        list.rows.push_back({table.rows[first][0].text, table.columns[c], table.rows[own][c].text,
                             table.rows[r][c].text, table.rows[r][1].text});
        break;
      }
    }
    first = end;
  }
  return list;
}

}  // namespace slim_init::tools
