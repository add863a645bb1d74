// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The report's files for programs.
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>

#include "slim_init/evaluation/report.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

using Json = nlohmann::json;

// An empty field is a number that does not exist.
std::string csvNumber(double value) { return std::isfinite(value) ? roundedText(9, value) : ""; }

std::string csvText(const std::string& field) {
  if (field.find_first_of(",\"\r\n") == std::string::npos) return field;
  return text(std::quoted(field, '"', '"'));  // quotes in it are doubled
}

std::string joined(const std::vector<std::string>& fields, const char* separator) {
  std::string text;
  for (const std::string& field : fields) text += (&field == &fields[0] ? "" : separator) + field;
  return text;
}

std::string csvRow(const std::vector<std::string>& fields) { return joined(fields, ",") + "\n"; }

std::string yesNo(bool value) { return value ? "1" : "0"; }

// "name=value;name=value"; names are identifiers of our own.
std::string gatesText(const std::vector<GateValue>& gates) {
  std::vector<std::string> texts;
  for (const GateValue& gate : gates) {
    texts.push_back(std::string(toString(gate.name)) + "=" + csvNumber(gate.value));
  }
  return joined(texts, ";");
}

std::string stagesText(const std::vector<StageTime>& stages) {
  std::vector<std::string> texts;
  for (const StageTime& stage : stages) texts.push_back(stage.name + "=" + csvNumber(stage.ms));
  return joined(texts, ";");
}

using Columns = std::vector<std::pair<const char*, std::string>>;  // name and value

Columns windowColumns(const RunInfo& info, const WindowRecord& window) {
  return {{"dataset", csvText(info.dataset)},
          {"trial", std::to_string(window.trial)},
          {"t_start_s", csvNumber(window.t_start)},
          {"t_start_ns", std::to_string(window.t_start_ns)},
          {"duration_s", csvNumber(window.duration_s)},
          {"keyframes", std::to_string(window.keyframes)},
          {"excited", yesNo(window.excitation.excited)},
          {"rig_td_ms", csvNumber(1e3 * window.rig.td_s)},
          {"rig_rotation_deg", csvNumber(window.rig.rotation_deg)},
          {"rig_readout_ms", csvNumber(1e3 * window.rig.readout_s)}};
}

Columns methodColumns(const std::string& method, const MethodRecord& record) {
  const InitResult& answer = record.answer;
  const WindowMetrics& metrics = record.metrics;
  const CalibrationErrors& calibration = record.calibration;
  const DownstreamRecord& downstream = record.downstream;
  return {{"method", csvText(method)},
          {"status", toString(answer.status)},
          {"answer_keyframes", std::to_string(record.keyframes)},
          {"answer_s", csvNumber(record.data_s)},
          {"attempted", yesNo(record.attempted())},
          {"success", yesNo(record.attempted() && metrics.success())},
          {"scale", csvNumber(metrics.scale)},
          {"scale_error", csvNumber(metrics.scale_error)},
          {"gravity_error_deg", csvNumber(metrics.gravity_error_deg)},
          {"velocity_rmse", csvNumber(metrics.velocity_rmse)},
          {"velocity_vec_rmse", csvNumber(metrics.velocity_vec_rmse)},
          {"pose_rmse", csvNumber(metrics.pose_rmse)},
          {"gyro_bias_err_pct", csvNumber(metrics.gyro_bias_err_pct)},
          {"gyro_bias_vec_err", csvNumber(metrics.gyro_bias_vec_err)},
          {"scale_sigma", csvNumber(answer.scale_sigma)},
          {"td_error_ms", csvNumber(1e3 * calibration.td_s)},
          {"td_sigma_ms", csvNumber(1e3 * calibration.td_sigma_s)},
          {"rotation_error_deg", csvNumber(calibration.rotation_deg)},
          {"rotation_sigma_deg", csvNumber(calibration.rotation_sigma_deg)},
          {"rotation_over_sigma", csvNumber(calibration.rotation_over_sigma)},
          {"readout_error_ms", csvNumber(1e3 * calibration.readout_s)},
          {"readout_sigma_ms", csvNumber(1e3 * calibration.readout_sigma_s)},
          {"noise_px", csvNumber(answer.track_noise.measured_px)},
          {"warnings", csvText(joined(answer.warnings, " | "))},
          {"point_tracks", std::to_string(answer.counts.point_tracks)},
          {"line_tracks", std::to_string(answer.counts.line_tracks)},
          {"gates", csvText(gatesText(answer.gates))},
          {"message", csvText(answer.message)},
          {"not_evaluated", csvText(metrics.failure)},
          {"downstream", yesNo(downstream.ran)},
          {"downstream_s", downstream.ran ? csvNumber(downstream.seconds) : ""},
          {"downstream_diverged", downstream.ran ? yesNo(downstream.diverged) : ""},
          {"downstream_ate", csvNumber(downstream.ate)},
          {"downstream_scale_error", csvNumber(downstream.scale_error)},
          {"downstream_message", csvText(downstream.message)},
          // Times come last: without the last three columns equal runs give equal bytes.
          {"solve_cpu_ms", csvNumber(record.solve_cpu_ms)},
          {"solve_ms", csvNumber(record.solve_ms)},
          {"stages_ms", csvText(stagesText(answer.stages))}};
}

Json jsonTracking(const TrackingSummary& tracking) {
  return {{"images", tracking.images},
          {"tracked", tracking.tracked},
          {"outside_imu", tracking.outside_imu},
          {"unreadable", tracking.unreadable},
          {"refused", tracking.refused},
          {"images_without_gyro", tracking.images_without_gyro},
          {"points", tracking.points},
          {"points_carried", tracking.points_carried},
          {"lines", tracking.lines},
          {"lines_carried", tracking.lines_carried},
          {"total_ms_median", tracking.total_ms_median}};
}

Json jsonSubset(const SubsetSummary& subset) {
  Json json = Json::object();
  for (const Figure& figure : subset.figures) {
    if (figure.is_count) {
      json[figure.key] = static_cast<int>(figure.value);
    } else {
      json[figure.key] = figure.value;
    }
  }
  json["statuses"] = subset.statuses;
  return json;
}

}  // namespace

std::string windowsCsv(const RunInfo& info, const ProtocolResult& result) {
  std::vector<std::string> names;
  for (const auto& column : windowColumns(info, {})) names.emplace_back(column.first);
  for (const auto& column : methodColumns("", {})) names.emplace_back(column.first);
  std::string text = csvRow(names);
  for (const WindowRecord& window : result.windows) {
    for (std::size_t m = 0; m < window.methods.size(); ++m) {
      std::vector<std::string> row;
      for (auto& column : windowColumns(info, window)) row.push_back(column.second);
      for (auto& column : methodColumns(result.methods[m], window.methods[m])) {
        row.push_back(column.second);
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
  for (const auto& [key, value] : info.options) {
    std::visit([&json = options[key]](const auto& v) { json = v; }, value);
  }
  const ProtocolCounts& counts = result.counts;
  json["trials"] = {{"frames", counts.frames},
                    {"trials", counts.trials},
                    {"windows", counts.windows},
                    {"without_truth", counts.without_truth},
                    {"not_evaluable", counts.not_evaluable},
                    {"ended", counts.ended},
                    {"interrupted", counts.interrupted},
                    {"repeated", counts.repeated},
                    {"invalid", counts.invalid}};
  json["has_truth"] = result.has_truth;
  if (result.first_keyframes > 0) json["first_keyframes"] = result.first_keyframes;
  json["version"] = info.version;
  json["commit"] = info.commit.empty() ? Json(nullptr) : Json(info.commit);
  if (!result.first_refusal.empty()) json["first_refusal"] = result.first_refusal;
  if (!info.method_notes.empty()) json["method_notes"] = info.method_notes;
  if (info.tracking.has_value()) json["tracking"] = jsonTracking(*info.tracking);
  if (!info.simulated.empty()) json["simulated"] = info.simulated;
  const StreamCounts& dropped = result.dropped;
  json["dropped"] = {{"imu_not_finite", dropped.imu[AddStatus::kNotFinite]},
                     {"imu_glitches", dropped.imu[AddStatus::kGlitch]},
                     {"imu_out_of_order", dropped.imu[AddStatus::kOutOfOrder]},
                     {"frames_not_finite", dropped.frames[AddStatus::kNotFinite]},
                     {"frames_out_of_order", dropped.frames[AddStatus::kOutOfOrder]},
                     {"observations_not_finite", dropped.observations_not_finite},
                     {"observations_duplicate_id", dropped.observations_duplicate_id},
                     {"lines_degenerate", dropped.lines_degenerate}};
  Json& methods = json["methods"] = Json::object();
  for (const MethodSummary& summary : summaries) {
    methods[summary.name] = {{"all", jsonSubset(summary.all)},
                             {"excited", jsonSubset(summary.excited)}};
  }
  // Numbers that are not finite become null. Names of files may hold bytes that are no UTF-8; they
  // are replaced rather than thrown at.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace slim_init::evaluation
