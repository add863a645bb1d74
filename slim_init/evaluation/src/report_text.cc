// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The report's files as text.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "slim_init/evaluation/report.h"
#include "statistics.h"

namespace slim_init::evaluation {
namespace {

using Json = nlohmann::json;

/// A column of summary.csv and a key of summary.json.
struct SummaryField {
  const char* key;
  double SubsetSummary::*real;
  int SubsetSummary::*count;
};

constexpr SummaryField kSummaryFields[] = {
    {"windows", nullptr, &SubsetSummary::windows},
    {"attempted", nullptr, &SubsetSummary::attempted},
    {"success", nullptr, &SubsetSummary::success},
    {"success_rate", &SubsetSummary::success_rate, nullptr},
    {"scale_rmse", &SubsetSummary::scale_rmse, nullptr},
    {"scale_median", &SubsetSummary::scale_median, nullptr},
    {"scale_p90", &SubsetSummary::scale_p90, nullptr},
    {"gravity_rmse_deg", &SubsetSummary::gravity_rmse_deg, nullptr},
    {"gravity_median_deg", &SubsetSummary::gravity_median_deg, nullptr},
    {"gravity_p90_deg", &SubsetSummary::gravity_p90_deg, nullptr},
    {"velocity_rmse", &SubsetSummary::velocity_rmse, nullptr},
    {"velocity_vec_rmse", &SubsetSummary::velocity_vec_rmse, nullptr},
    {"pose_rmse", &SubsetSummary::pose_rmse, nullptr},
    {"gyro_bias_err_pct", &SubsetSummary::gyro_bias_err_pct, nullptr},
    {"gyro_bias_vec_rmse", &SubsetSummary::gyro_bias_vec_rmse, nullptr},
    {"accepted", nullptr, &SubsetSummary::accepted},
    {"accepted_within_0_1", nullptr, &SubsetSummary::accepted_within_0_1},
    {"accepted_within_0_5", nullptr, &SubsetSummary::accepted_within_0_5},
    {"accepted_within_0_1_rate", &SubsetSummary::accepted_within_0_1_rate, nullptr},
    {"accepted_within_0_5_rate", &SubsetSummary::accepted_within_0_5_rate, nullptr},
    {"accepted_scale_error_max", &SubsetSummary::accepted_scale_error_max, nullptr},
    {"accepted_rate", &SubsetSummary::accepted_rate, nullptr},
    {"accepted_scale_rmse", &SubsetSummary::accepted_scale_rmse, nullptr},
    {"accepted_scale_median", &SubsetSummary::accepted_scale_median, nullptr},
    {"accepted_gravity_rmse_deg", &SubsetSummary::accepted_gravity_rmse_deg, nullptr},
    {"accepted_velocity_rmse", &SubsetSummary::accepted_velocity_rmse, nullptr},
    {"accept_s_median", &SubsetSummary::accept_s_median, nullptr},
    {"accept_s_p90", &SubsetSummary::accept_s_p90, nullptr},
    {"accept_keyframes_median", &SubsetSummary::accept_keyframes_median, nullptr},
    {"downstream_runs", nullptr, &SubsetSummary::downstream_runs},
    {"downstream_diverged", nullptr, &SubsetSummary::downstream_diverged},
    {"downstream_divergence_rate", &SubsetSummary::downstream_divergence_rate, nullptr},
    {"downstream_ate_median", &SubsetSummary::downstream_ate_median, nullptr},
    {"downstream_ate_p90", &SubsetSummary::downstream_ate_p90, nullptr},
    {"downstream_scale_median", &SubsetSummary::downstream_scale_median, nullptr},
    {"downstream_scale_p90", &SubsetSummary::downstream_scale_p90, nullptr},
    {"waiting", nullptr, &SubsetSummary::waiting},
    {"refused", nullptr, &SubsetSummary::refused},
    {"failed", nullptr, &SubsetSummary::failed},
    {"solve_ms_median", &SubsetSummary::solve_ms_median, nullptr},
    {"solve_ms_mean", &SubsetSummary::solve_ms_mean, nullptr},
};

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), pattern, value);
  return text;
}

// An empty field is a number that does not exist.
std::string csvNumber(double value) { return std::isfinite(value) ? format("%.9g", value) : ""; }

std::string csvText(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string csvRow(const std::vector<std::string>& fields) {
  std::string row;
  for (std::size_t i = 0; i < fields.size(); ++i) row += (i > 0 ? "," : "") + fields[i];
  return row + "\n";
}

std::string yesNo(bool value) { return value ? "1" : "0"; }

// "name=value;name=value"; names are identifiers of our own.
std::string joinGates(const std::vector<GateValue>& gates) {
  std::string text;
  for (const GateValue& gate : gates) {
    if (!text.empty()) text += ';';
    text += gate.name + "=" + csvNumber(gate.value);
  }
  return text;
}

std::string joinStages(const std::vector<StageTime>& stages) {
  std::string text;
  for (const StageTime& stage : stages) {
    if (!text.empty()) text += ';';
    text += stage.name + "=" + csvNumber(stage.ms);
  }
  return text;
}

Json jsonNumber(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json jsonOption(const OptionValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return jsonNumber(*number);
  return std::visit([](const auto& v) { return Json(v); }, value);
}

std::string optionText(const OptionValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
  if (const auto* number = std::get_if<double>(&value)) return format("%g", *number);
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  std::string joined;
  for (const std::string& item : std::get<std::vector<std::string>>(value)) {
    joined += (joined.empty() ? "" : ", ") + item;
  }
  return joined;
}

Json jsonTracking(const TrackingSummary& tracking) {
  Json json = {{"images", tracking.images},
               {"tracked", tracking.tracked},
               {"outside_imu", tracking.outside_imu},
               {"unreadable", tracking.unreadable},
               {"refused", tracking.refused},
               {"images_without_gyro", tracking.images_without_gyro},
               {"images_with_vp", tracking.images_with_vp},
               {"points", jsonNumber(tracking.points)},
               {"points_p10", jsonNumber(tracking.points_p10)},
               {"points_carried", jsonNumber(tracking.points_carried)},
               {"lines", jsonNumber(tracking.lines)},
               {"lines_p10", jsonNumber(tracking.lines_p10)},
               {"lines_carried", jsonNumber(tracking.lines_carried)},
               {"line_detector", tracking.line_detector},
               {"total_ms_median", jsonNumber(tracking.total_ms_median)},
               {"total_ms_p90", jsonNumber(tracking.total_ms_p90)}};
  Json& stages = json["stages_ms_median"] = Json::object();
  for (const StageTime& stage : tracking.stages_ms_median) {
    stages[stage.name] = jsonNumber(stage.ms);
  }
  return json;
}

Json jsonSubset(const SubsetSummary& subset) {
  Json json = Json::object();
  for (const SummaryField& field : kSummaryFields) {
    json[field.key] =
        field.real != nullptr ? jsonNumber(subset.*field.real) : Json(subset.*field.count);
  }
  json["statuses"] = subset.statuses;
  Json& partial = json["partial"] = Json::object();
  for (const auto& [status, errors] : subset.partial) {
    partial[status] = {{"windows", errors.windows},
                       {"gravity_median_deg", jsonNumber(errors.gravity_median_deg)},
                       {"gravity_max_deg", jsonNumber(errors.gravity_max_deg)},
                       {"gyro_bias_median_pct", jsonNumber(errors.gyro_bias_median_pct)},
                       {"gyro_bias_max_pct", jsonNumber(errors.gyro_bias_max_pct)},
                       {"gyro_bias_vec_rmse", jsonNumber(errors.gyro_bias_vec_rmse)}};
  }
  return json;
}

/// A column of the tables for people.
struct TableColumn {
  const char* title;
  bool needs_truth;
  std::string (*cell)(const SubsetSummary& s);
};

std::string cell(const char* pattern, double value, double factor = 1.0) {
  return std::isfinite(value) ? format(pattern, factor * value) : "-";
}

const TableColumn kTableColumns[] = {
    {"success %", true, [](const SubsetSummary& s) { return cell("%.1f", s.success_rate, 100.0); }},
    {"scale rmse", true, [](const SubsetSummary& s) { return cell("%.4f", s.scale_rmse); }},
    {"median", true, [](const SubsetSummary& s) { return cell("%.4f", s.scale_median); }},
    {"p90", true, [](const SubsetSummary& s) { return cell("%.4f", s.scale_p90); }},
    {"gravity deg", true, [](const SubsetSummary& s) { return cell("%.3f", s.gravity_rmse_deg); }},
    {"speed m/s", true, [](const SubsetSummary& s) { return cell("%.4f", s.velocity_rmse); }},
    {"velocity m/s", true,
     [](const SubsetSummary& s) { return cell("%.4f", s.velocity_vec_rmse); }},
    {"pose m", true, [](const SubsetSummary& s) { return cell("%.4f", s.pose_rmse); }},
    {"gyro bias %", true, [](const SubsetSummary& s) { return cell("%.2f", s.gyro_bias_err_pct); }},
    {"accepted", false, [](const SubsetSummary& s) { return std::to_string(s.accepted); }},
    {"of them < 0.1 %", true,
     [](const SubsetSummary& s) { return cell("%.1f", s.accepted_within_0_1_rate, 100.0); }},
    {"solve ms", false, [](const SubsetSummary& s) { return cell("%.3f", s.solve_ms_median); }},
};

/// Of what the methods themselves called a success, and in the anytime protocol how soon.
const TableColumn kAcceptedColumns[] = {
    {"accepted %", false,
     [](const SubsetSummary& s) { return cell("%.1f", s.accepted_rate, 100.0); }},
    {"time to accept s, median", false,
     [](const SubsetSummary& s) { return cell("%.2f", s.accept_s_median); }},
    {"p90", false, [](const SubsetSummary& s) { return cell("%.2f", s.accept_s_p90); }},
    {"keyframes, median", false,
     [](const SubsetSummary& s) { return cell("%.0f", s.accept_keyframes_median); }},
    {"scale rmse", true,
     [](const SubsetSummary& s) { return cell("%.4f", s.accepted_scale_rmse); }},
    {"median", true, [](const SubsetSummary& s) { return cell("%.4f", s.accepted_scale_median); }},
    {"largest", true,
     [](const SubsetSummary& s) { return cell("%.4f", s.accepted_scale_error_max); }},
    {"< 0.1 %", true,
     [](const SubsetSummary& s) { return cell("%.1f", s.accepted_within_0_1_rate, 100.0); }},
    {"< 0.5 %", true,
     [](const SubsetSummary& s) { return cell("%.1f", s.accepted_within_0_5_rate, 100.0); }},
    {"gravity deg", true,
     [](const SubsetSummary& s) { return cell("%.3f", s.accepted_gravity_rmse_deg); }},
    {"speed m/s", true,
     [](const SubsetSummary& s) { return cell("%.4f", s.accepted_velocity_rmse); }},
};

/// Of the estimator that was run from the accepted answers.
const TableColumn kDownstreamColumns[] = {
    {"runs", false, [](const SubsetSummary& s) { return std::to_string(s.downstream_runs); }},
    {"diverged %", false,
     [](const SubsetSummary& s) { return cell("%.1f", s.downstream_divergence_rate, 100.0); }},
    {"ATE m, median", true,
     [](const SubsetSummary& s) { return cell("%.3f", s.downstream_ate_median); }},
    {"p90", true, [](const SubsetSummary& s) { return cell("%.3f", s.downstream_ate_p90); }},
    {"final scale error, median", true,
     [](const SubsetSummary& s) { return cell("%.4f", s.downstream_scale_median); }},
    {"p90", true, [](const SubsetSummary& s) { return cell("%.4f", s.downstream_scale_p90); }},
};

using Subset = SubsetSummary MethodSummary::*;

int windowsOf(const std::vector<MethodSummary>& summaries, Subset subset) {
  return summaries.empty() ? 0 : (summaries.front().*subset).windows;
}

/// Without truth the columns that need it are left out.
template <std::size_t N>
std::vector<std::vector<std::string>> tableCells(const TableColumn (&columns)[N],
                                                 const std::vector<MethodSummary>& summaries,
                                                 Subset subset, bool has_truth) {
  std::vector<std::vector<std::string>> rows(1, {"method"});
  for (const MethodSummary& summary : summaries) rows.push_back({summary.name});
  for (const TableColumn& column : columns) {
    if (column.needs_truth && !has_truth) continue;
    rows.front().emplace_back(column.title);
    for (std::size_t m = 0; m < summaries.size(); ++m) {
      rows[m + 1].push_back(column.cell(summaries[m].*subset));
    }
  }
  return rows;
}

// Data and messages are not ours: a bar would end the cell, a line end the table.
std::string markdownText(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c == '\n' || c == '\r' ? ' ' : c;
  }
  return escaped;
}

std::string markdownTable(const std::vector<std::vector<std::string>>& rows) {
  std::string text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    text += "|";
    for (const std::string& field : rows[r]) text += " " + markdownText(field) + " |";
    text += "\n";
    if (r > 0) continue;
    for (std::size_t c = 0; c < rows[r].size(); ++c) text += c == 0 ? "|---|" : "---:|";
    text += "\n";
  }
  return text;
}

/// For a terminal: names to the left, numbers to the right.
std::string alignedTable(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string padding(widths[c] - row[c].size(), ' ');
      text += c == 0 ? "  " + row[c] + padding : "  " + padding + row[c];
    }
    text += "\n";
  }
  return text;
}

std::string plural(int count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

void writeRun(const RunInfo& info, const ProtocolResult& result, std::ostringstream& out) {
  out << "# A/B initialization on " << info.dataset << "\n\n"
      << "## What was run\n\n```\n"
      << info.command << "\n```\n\n| option | value |\n|---|---|\n";
  for (const auto& [key, value] : info.options) {
    out << "| " << key << " | " << markdownText(optionText(value)) << " |\n";
  }
  out << "| true gyro bias | " << info.gyro_bias_truth << " |\n| program | slim_init "
      << info.version << (info.commit.empty() ? "" : ", commit " + info.commit) << " |\n\n";

  const ProtocolCounts& counts = result.counts;
  const int excited = static_cast<int>(
      std::count_if(result.windows.begin(), result.windows.end(),
                    [](const WindowRecord& window) { return window.excitation.excited; }));
  out << plural(counts.trials, "trial") << " over " << plural(counts.frames, "frame") << " gave "
      << plural(counts.windows, "window") << ", " << excited
      << " of them excited. Not evaluated: " << counts.ended
      << " (data end before the window is full), " << counts.interrupted
      << " (interrupted by a gap), " << counts.repeated
      << " (same keyframes as the window before), " << counts.without_truth
      << " (no truth at a keyframe), " << counts.invalid << " (data refused"
      << (result.first_refusal.empty() ? "" : ", first: " + markdownText(result.first_refusal))
      << ").\n";
  const WindowCounts& dropped = result.dropped;
  out << "Dropped on the way, over all trials: " << dropped.imu_not_finite
      << " IMU samples not finite, " << dropped.imu_out_of_order << " out of order; "
      << dropped.frames_not_finite << " frames not finite, " << dropped.frames_out_of_order
      << " out of order; " << dropped.observations_not_finite << " observations not finite, "
      << dropped.observations_duplicate_id << " with a repeated id, " << dropped.lines_degenerate
      << " lines without length.\n";
  if (!info.notes.empty()) {
    out << "\nNotes on the data:\n\n";
    for (const std::string& note : info.notes) out << "- " << note << "\n";
  }
}

void writeAccepted(const ProtocolResult& result, const std::vector<MethodSummary>& summaries,
                   std::ostringstream& out) {
  out << "\n## Accepted answers";
  if (result.first_keyframes > 0) {
    out << ", windows growing from " << result.first_keyframes
        << " keyframes\n\nEvery trial hands a method a window of " << result.first_keyframes
        << " keyframes, then one with a keyframe more, and so on until it accepts; what it says "
           "then counts,\nin the tables above too. Time to accept is the data from the first to "
           "the "
           "last keyframe of that window";
  }
  out << (result.first_keyframes > 0 ? ".\n" : "\n");
  for (const bool excited : {true, false}) {
    const Subset subset = excited ? &MethodSummary::excited : &MethodSummary::all;
    out << "\n"
        << (excited ? "Excited windows:" : "All windows:") << "\n\n"
        << markdownTable(tableCells(kAcceptedColumns, summaries, subset, result.has_truth));
  }
}

void writeDownstream(const ProtocolResult& result, const std::vector<MethodSummary>& summaries,
                     std::ostringstream& out) {
  if (!result.has_downstream) return;
  out << "\n## What an estimator makes of the accepted answers\n\n"
         "The same sliding-window back end was started from every accepted answer and ran on the "
         "same\ntracks. Final scale error is that of its last window.\n";
  for (const bool excited : {true, false}) {
    const Subset subset = excited ? &MethodSummary::excited : &MethodSummary::all;
    out << "\n"
        << (excited ? "Excited windows:" : "All windows:") << "\n\n"
        << markdownTable(tableCells(kDownstreamColumns, summaries, subset, result.has_truth));
  }
}

void writePictures(const RunInfo& info, std::ostringstream& out) {
  if (info.pictures.empty() && info.picture_note.empty()) return;
  out << "\n## Pictures\n\n";
  if (info.pictures.empty()) out << info.picture_note << "\n";
  for (std::size_t i = 0; i < info.pictures.size(); ++i) {
    const auto& [file, title] = info.pictures[i];
    out << (i > 0 ? "\n" : "") << "![" << markdownText(title) << "](" << file << ")\n\n"
        << markdownText(title) << "\n";
  }
}

void writeTracking(const TrackingSummary& tracking, std::ostringstream& out) {
  out << "\n## Features from images\n\n"
      << tracking.tracked << " of " << plural(tracking.images, "image") << " tracked; "
      << tracking.outside_imu << " outside the IMU data, " << tracking.unreadable << " unreadable, "
      << tracking.refused << " refused, " << tracking.images_without_gyro
      << " tracked without the gyro's rotation. A vanishing point was found in "
      << tracking.images_with_vp << ".";
  if (!tracking.line_detector.empty()) out << " Line detector: " << tracking.line_detector << ".";
  const auto row = [](const std::string& name, double median_value, double p10, double carried) {
    return std::vector<std::string>{name, cell("%.0f", median_value), cell("%.0f", p10),
                                    cell("%.0f", carried)};
  };
  out << "\n\n"
      << markdownTable(
             {{"a frame", "median", "10 % quantile", "of them from the frame before, median"},
              row("points", tracking.points, tracking.points_p10, tracking.points_carried),
              row("lines", tracking.lines, tracking.lines_p10, tracking.lines_carried)})
      << "\nFront end, one image [ms]: median " << cell("%.2f", tracking.total_ms_median)
      << ", 90 % quantile " << cell("%.2f", tracking.total_ms_p90) << "; median per stage:";
  for (std::size_t i = 0; i < tracking.stages_ms_median.size(); ++i) {
    out << (i > 0 ? ", " : " ") << tracking.stages_ms_median[i].name << " "
        << cell("%.2f", tracking.stages_ms_median[i].ms);
  }
  out << ".\n";
}

/// What was known where no trajectory was.
void writePartial(const std::vector<MethodSummary>& summaries, std::ostringstream& out) {
  std::vector<std::vector<std::string>> rows(
      1, {"method", "status", "windows", "gravity deg, median", "max", "gyro bias %, median", "max",
          "gyro bias rad/s, rms"});
  for (const MethodSummary& summary : summaries) {
    for (const auto& [status, partial] : summary.all.partial) {
      rows.push_back(
          {summary.name, status, std::to_string(partial.windows),
           cell("%.3f", partial.gravity_median_deg), cell("%.3f", partial.gravity_max_deg),
           cell("%.2f", partial.gyro_bias_median_pct), cell("%.2f", partial.gyro_bias_max_pct),
           cell("%.5f", partial.gyro_bias_vec_rmse)});
    }
  }
  if (rows.size() == 1) return;
  out << "\n## Answers without a trajectory\n\nGravity and gyroscope bias of windows in which "
         "nothing more is observable.\n\n"
      << markdownTable(rows);
}

void writeStatuses(const std::vector<MethodSummary>& summaries, std::ostringstream& out) {
  std::set<std::string> names;
  for (const MethodSummary& summary : summaries) {
    for (const auto& status : summary.all.statuses) names.insert(status.first);
  }
  std::vector<std::vector<std::string>> rows(1, {"method", "windows", "with estimate"});
  rows.front().insert(rows.front().end(), names.begin(), names.end());
  for (const MethodSummary& summary : summaries) {
    rows.push_back(
        {summary.name, std::to_string(summary.all.windows), std::to_string(summary.all.attempted)});
    for (const std::string& name : names) {
      const auto found = summary.all.statuses.find(name);
      rows.back().push_back(
          std::to_string(found == summary.all.statuses.end() ? 0 : found->second));
    }
  }
  out << "\n## Verdicts (all windows)\n\n" << markdownTable(rows);
}

void writeTimes(const ProtocolResult& result, const std::vector<MethodSummary>& summaries,
                std::ostringstream& out) {
  out << "\n## Time per solve, windows with an estimate\n\n";
  std::vector<std::vector<std::string>> rows(1, {"method", "median ms", "mean ms"});
  for (const MethodSummary& summary : summaries) {
    rows.push_back({summary.name, cell("%.3f", summary.all.solve_ms_median),
                    cell("%.3f", summary.all.solve_ms_mean)});
  }
  out << markdownTable(rows);
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    // Stages in the order in which they first occur.
    std::vector<std::pair<std::string, std::vector<double>>> stages;
    for (const WindowRecord& window : result.windows) {
      if (!window.methods[m].attempted) continue;
      for (const StageTime& stage : window.methods[m].stages) {
        auto found = std::find_if(stages.begin(), stages.end(),
                                  [&](const auto& known) { return known.first == stage.name; });
        if (found == stages.end()) found = stages.insert(stages.end(), {stage.name, {}});
        if (std::isfinite(stage.ms)) found->second.push_back(stage.ms);
      }
    }
    if (stages.empty()) continue;
    out << "\n`" << result.methods[m] << "`, median per stage [ms]:";
    for (std::size_t i = 0; i < stages.size(); ++i) {
      out << (i > 0 ? ", " : " ") << stages[i].first << " "
          << cell("%.3f", median(stages[i].second));
    }
    out << "\n";
  }
}

}  // namespace

std::string windowsCsv(const RunInfo& info, const ProtocolResult& result) {
  // Wall-clock times come last: without the last two columns equal runs give equal bytes.
  std::string text = csvRow({"dataset",
                             "trial",
                             "t_start_s",
                             "t_start_ns",
                             "duration_s",
                             "keyframes",
                             "excited",
                             "force_deviation",
                             "quiet_pairs",
                             "p_x",
                             "p_y",
                             "p_z",
                             "method",
                             "status",
                             "answer_keyframes",
                             "answer_s",
                             "attempted",
                             "success",
                             "scale",
                             "scale_error",
                             "gravity_error_deg",
                             "velocity_rmse",
                             "velocity_vec_rmse",
                             "pose_rmse",
                             "gyro_bias_err_pct",
                             "gyro_bias_vec_err",
                             "scale_sigma",
                             "point_tracks",
                             "line_tracks",
                             "gates",
                             "message",
                             "not_evaluated",
                             "downstream",
                             "downstream_s",
                             "downstream_diverged",
                             "downstream_ate",
                             "downstream_scale_error",
                             "downstream_message",
                             "solve_ms",
                             "stages_ms"});
  for (const WindowRecord& window : result.windows) {
    for (std::size_t m = 0; m < window.methods.size(); ++m) {
      const MethodRecord& record = window.methods[m];
      const WindowMetrics& metrics = record.metrics;
      text += csvRow({csvText(info.dataset),
                      std::to_string(window.trial),
                      csvNumber(window.t_start),
                      std::to_string(window.t_start_ns),
                      csvNumber(window.duration_s),
                      std::to_string(window.keyframes),
                      yesNo(window.excitation.excited),
                      csvNumber(window.excitation.mean_deviation),
                      std::to_string(window.excitation.quiet_pairs),
                      csvNumber(window.p_w_b.x()),
                      csvNumber(window.p_w_b.y()),
                      csvNumber(window.p_w_b.z()),
                      csvText(result.methods[m]),
                      toString(record.status),
                      std::to_string(record.keyframes),
                      csvNumber(record.data_s),
                      yesNo(record.attempted),
                      yesNo(record.attempted && metrics.success()),
                      csvNumber(metrics.scale),
                      csvNumber(metrics.scale_error),
                      csvNumber(metrics.computed() ? metrics.gravity_error_deg
                                                   : record.partial.gravity_error_deg),
                      csvNumber(metrics.velocity_rmse),
                      csvNumber(metrics.velocity_vec_rmse),
                      csvNumber(metrics.pose_rmse),
                      csvNumber(metrics.computed() ? metrics.gyro_bias_err_pct
                                                   : record.partial.gyro_bias_err_pct),
                      csvNumber(metrics.computed() ? metrics.gyro_bias_vec_err
                                                   : record.partial.gyro_bias_vec_err),
                      csvNumber(record.scale_sigma),
                      std::to_string(record.point_tracks),
                      std::to_string(record.line_tracks),
                      csvText(joinGates(record.gates)),
                      csvText(record.message),
                      csvText(metrics.failure),
                      yesNo(record.downstream.ran),
                      record.downstream.ran ? csvNumber(record.downstream.seconds) : "",
                      record.downstream.ran ? yesNo(record.downstream.diverged) : "",
                      csvNumber(record.downstream.ate),
                      csvNumber(record.downstream.scale_error),
                      csvText(record.downstream.message),
                      csvNumber(record.solve_ms),
                      csvText(joinStages(record.stages))});
    }
  }
  return text;
}

std::string summaryCsv(const RunInfo& info, const std::vector<MethodSummary>& summaries) {
  std::vector<std::string> header = {"dataset", "method", "subset"};
  for (const SummaryField& field : kSummaryFields) header.emplace_back(field.key);
  std::string text = csvRow(header);
  for (const MethodSummary& summary : summaries) {
    for (const bool excited : {false, true}) {
      const SubsetSummary& subset = excited ? summary.excited : summary.all;
      std::vector<std::string> row = {csvText(info.dataset), csvText(summary.name),
                                      excited ? "excited" : "all"};
      for (const SummaryField& field : kSummaryFields) {
        row.push_back(field.real != nullptr ? csvNumber(subset.*field.real)
                                            : std::to_string(subset.*field.count));
      }
      text += csvRow(row);
    }
  }
  return text;
}

std::string summaryJson(const RunInfo& info, const ProtocolResult& result,
                        const std::vector<MethodSummary>& summaries) {
  Json json = Json::object();
  json["dataset"] = info.dataset;
  json["command"] = info.command;
  json["gyro_bias_truth"] = info.gyro_bias_truth;
  json["notes"] = info.notes;
  Json& options = json["options"] = Json::object();
  for (const auto& [key, value] : info.options) options[key] = jsonOption(value);
  const ProtocolCounts& counts = result.counts;
  json["trials"] = {{"frames", counts.frames},     {"trials", counts.trials},
                    {"windows", counts.windows},   {"without_truth", counts.without_truth},
                    {"ended", counts.ended},       {"interrupted", counts.interrupted},
                    {"repeated", counts.repeated}, {"invalid", counts.invalid}};
  json["has_truth"] = result.has_truth;
  if (result.first_keyframes > 0) json["first_keyframes"] = result.first_keyframes;
  json["version"] = info.version;
  json["commit"] = info.commit.empty() ? Json(nullptr) : Json(info.commit);
  if (info.tracking.has_value()) json["tracking"] = jsonTracking(*info.tracking);
  if (!info.simulated.empty()) {
    Json& simulated = json["simulated"] = Json::object();
    for (const auto& [name, count] : info.simulated) simulated[name] = count;
  }
  const WindowCounts& dropped = result.dropped;
  json["dropped"] = {{"imu_not_finite", dropped.imu_not_finite},
                     {"imu_out_of_order", dropped.imu_out_of_order},
                     {"frames_not_finite", dropped.frames_not_finite},
                     {"frames_out_of_order", dropped.frames_out_of_order},
                     {"observations_not_finite", dropped.observations_not_finite},
                     {"observations_duplicate_id", dropped.observations_duplicate_id},
                     {"lines_degenerate", dropped.lines_degenerate}};
  Json& methods = json["methods"] = Json::object();
  for (const MethodSummary& summary : summaries) {
    methods[summary.name] = {{"all", jsonSubset(summary.all)},
                             {"excited", jsonSubset(summary.excited)}};
  }
  // Names of files may hold bytes that are no UTF-8; they are replaced rather than thrown at.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string reportMarkdown(const RunInfo& info, const ProtocolResult& result,
                           const std::vector<MethodSummary>& summaries) {
  std::ostringstream out;
  writeRun(info, result, out);
  out << "\n## Excited windows (" << windowsOf(summaries, &MethodSummary::excited) << ")\n\n"
      << markdownTable(
             tableCells(kTableColumns, summaries, &MethodSummary::excited, result.has_truth))
      << "\n## All windows (" << windowsOf(summaries, &MethodSummary::all) << ")\n\n"
      << markdownTable(tableCells(kTableColumns, summaries, &MethodSummary::all, result.has_truth));
  if (!result.has_truth) {
    out << "\nThere is no ground truth, so no error was computed: the tables tell what the methods "
           "said.\n";
  }
  if (!info.method_notes.empty()) {
    out << "\nVariants:\n\n";
    for (const auto& [name, sentence] : info.method_notes) {
      out << "- `" << name << "`: " << sentence << "\n";
    }
  }
  writeAccepted(result, summaries, out);
  writeDownstream(result, summaries, out);
  writePictures(info, out);
  writeStatuses(summaries, out);
  writePartial(summaries, out);
  if (info.tracking.has_value()) writeTracking(*info.tracking, out);
  if (!info.simulated.empty()) {
    out << "\n## Simulated features\n\n";
    for (std::size_t i = 0; i < info.simulated.size(); ++i) {
      out << (i > 0 ? ", " : "") << info.simulated[i].first << " " << info.simulated[i].second;
    }
    out << ".\n";
  }
  writeTimes(result, summaries, out);
  out << "\n## How to read this\n\n"
         "Every method saw the same windows, byte for byte. With s the scale of the Sim(3) "
         "alignment\n"
         "of the estimated positions to the truth, a window is a success when the method returned "
         "an\n"
         "estimate with |s - 1| < 0.5, whatever its own verdict; the success rate is taken over "
         "all\n"
         "windows of the table, those without an estimate included. Scale, gravity, speed, "
         "velocity,\n"
         "pose and gyro bias are root mean squares over successful windows only (the protocol of "
         "the\n"
         "paper), so a method with a low success rate is measured on its easier windows: read the\n"
         "success rate first, and the median and the 90 % quantile (p90) beside the root mean "
         "square.\n"
         "\"Excited\" leaves out windows in which the accelerometer shows hardly more than "
         "gravity,\n"
         "where scale is not observable. \"Accepted\" counts the windows that the method itself "
         "called\n"
         "a success, which is all a user sees in flight, and the share of those within 10 % of "
         "the\n"
         "true scale. A dash is a number that does not exist. Definitions: docs/evaluation.md; "
         "one\n"
         "row per window and method, with message and gate values: windows.csv.\n";
  return out.str();
}

std::string summaryTable(const ProtocolResult& result,
                         const std::vector<MethodSummary>& summaries) {
  std::ostringstream out;
  for (const bool excited : {true, false}) {
    const Subset subset = excited ? &MethodSummary::excited : &MethodSummary::all;
    const auto rows = tableCells(kTableColumns, summaries, subset, result.has_truth);
    out << (excited ? "" : "\n")
        << plural(windowsOf(summaries, subset), excited ? "excited window" : "window")
        << (excited ? "" : " in all") << "\n";
    if (windowsOf(summaries, subset) > 0) out << alignedTable(rows);
  }
  if (result.has_downstream) {
    out << "\nBack end from the accepted answers, all windows\n"
        << alignedTable(
               tableCells(kDownstreamColumns, summaries, &MethodSummary::all, result.has_truth));
  }
  out << "\nVerdicts, all windows\n";
  std::size_t width = 0;
  for (const MethodSummary& summary : summaries) width = std::max(width, summary.name.size());
  for (const MethodSummary& summary : summaries) {
    out << "  " << summary.name << std::string(width - summary.name.size() + 2, ' ');
    const char* separator = "";
    for (const auto& [status, count] : summary.all.statuses) {
      out << separator << status << " " << count;
      separator = ", ";
    }
    out << "\n";
  }
  return out.str();
}

}  // namespace slim_init::evaluation
