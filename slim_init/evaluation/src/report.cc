// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "slim_init/evaluation/statistics.h"
#include "slim_init/evaluation/write_file.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;

using Record = MethodRecord;

double scaleError(const Record& r) { return r.metrics.scale_error; }
double gravity(const Record& r) { return r.metrics.gravity_error_deg; }
double velocity(const Record& r) { return r.metrics.velocity_rmse; }
double velocityVector(const Record& r) { return r.metrics.velocity_vec_rmse; }
double pose(const Record& r) { return r.metrics.pose_rmse; }
double biasPercent(const Record& r) { return r.metrics.gyro_bias_err_pct; }
double scaleOverSigma(const Record& r) { return r.metrics.scale_error / r.answer.scale_sigma; }
double tdMs(const Record& r) { return 1e3 * r.calibration.td_s; }
double tdOverSigma(const Record& r) { return r.calibration.tdOverSigma(); }
double rotation(const Record& r) { return r.calibration.rotation_deg; }
double rotationOverSigma(const Record& r) { return r.calibration.rotation_over_sigma; }
double readoutMs(const Record& r) { return 1e3 * r.calibration.readout_s; }
double seconds(const Record& r) { return r.data_s; }
double ate(const Record& r) { return r.downstream.ate; }
double lastScale(const Record& r) { return r.downstream.scale_error; }
double cpuMs(const Record& r) { return r.solve_cpu_ms; }

bool any(const Record& /*r*/) { return true; }
bool attempted(const Record& r) { return r.attempted(); }
bool successful(const Record& r) { return r.attempted() && r.metrics.success(); }
bool accepted(const Record& r) { return r.accepted(); }
bool evaluated(const Record& r) { return r.accepted() && r.metrics.computed(); }
bool within10(const Record& r) { return evaluated(r) && scaleError(r) < 0.1; }
bool beyond25(const Record& r) { return evaluated(r) && scaleError(r) > 0.25; }
bool ran(const Record& r) { return r.accepted() && r.downstream.ran; }
bool diverged(const Record& r) { return ran(r) && r.downstream.diverged; }

double middle(const std::vector<double>& values) { return median(values); }
double p90(const std::vector<double>& values) { return quantile(values, 0.9); }
double largest(const std::vector<double>& values) { return quantile(values, 1.0); }
constexpr auto rms = rootMeanSquare;

using Is = bool (*)(const Record&);

/// A figure of the windows that are `over`: their number, that as a fraction of those that are
/// `of`, or what `reduce` makes of the finite ones of their values.
struct Definition {
  const char* key;
  Is over;
  Is of = nullptr;
  double (*value)(const Record&) = nullptr;
  double (*reduce)(const std::vector<double>&) = nullptr;
  bool needs_truth = false;

  double ofWindows(const std::vector<const Record*>& records, bool has_truth) const;
};

constexpr Definition count(const char* key, Is over) { return {key, over}; }
constexpr Definition fraction(const char* key, Is over, Is of, bool needs_truth = false) {
  return {key, over, of, nullptr, nullptr, needs_truth};
}
constexpr Definition figure(const char* key, Is over, double (*value)(const Record&),
                            double (*reduce)(const std::vector<double>&)) {
  return {key, over, nullptr, value, reduce};
}

double Definition::ofWindows(const std::vector<const Record*>& records, bool has_truth) const {
  if (needs_truth && !has_truth) return kNotComputed;
  std::vector<double> values;
  double part = 0.0, whole = 0.0;
  for (const Record* record : records) {
    if (of != nullptr && of(*record)) ++whole;
    if (!over(*record)) continue;
    ++part;
    if (value == nullptr) continue;
    const double x = value(*record);
    if (std::isfinite(x)) values.push_back(x);
  }
  if (reduce != nullptr) return reduce(values);
  if (of == nullptr) return part;
  return whole > 0.0 ? part / whole : kNotComputed;
}

constexpr Definition kDefinitions[] = {
    count("windows", any),
    count("attempted", attempted),
    count("success", successful),
    fraction("success_rate", successful, any, true),
    figure("scale_rmse", successful, scaleError, rms),
    figure("scale_median", successful, scaleError, middle),
    figure("scale_p90", successful, scaleError, p90),
    figure("gravity_rmse_deg", successful, gravity, rms),
    figure("velocity_rmse", successful, velocity, rms),
    figure("velocity_vec_rmse", successful, velocityVector, rms),
    figure("pose_rmse", successful, pose, rms),
    figure("gyro_bias_err_pct", successful, biasPercent, rms),
    count("accepted", accepted),
    count("accepted_beyond_0_25", beyond25),
    fraction("accepted_within_0_1_rate", within10, accepted, true),
    figure("accepted_scale_error_max", evaluated, scaleError, largest),
    fraction("accepted_rate", accepted, any),
    figure("accepted_scale_rmse", evaluated, scaleError, rms),
    figure("accepted_scale_over_sigma", evaluated, scaleOverSigma, rms),
    figure("accepted_td_rmse_ms", accepted, tdMs, rms),
    figure("accepted_td_over_sigma", accepted, tdOverSigma, rms),
    figure("accepted_rotation_rmse_deg", accepted, rotation, rms),
    figure("accepted_rotation_over_sigma", accepted, rotationOverSigma, rms),
    figure("accepted_readout_rmse_ms", accepted, readoutMs, rms),
    figure("accept_s_median", accepted, seconds, middle),
    figure("accept_s_p90", accepted, seconds, p90),
    fraction("right_rate", within10, any, true),
    figure("right_s_median", within10, seconds, middle),
    figure("right_s_p90", within10, seconds, p90),
    count("downstream_runs", ran),
    count("downstream_diverged", diverged),
    fraction("downstream_divergence_rate", diverged, ran),
    figure("downstream_ate_median", ran, ate, middle),
    figure("downstream_ate_p90", ran, ate, p90),
    figure("downstream_scale_median", ran, lastScale, middle),
    figure("downstream_scale_p90", ran, lastScale, p90),
    figure("solve_cpu_ms_median", attempted, cpuMs, middle),
};

SubsetSummary subsetOf(const std::vector<const Record*>& records, bool has_truth) {
  SubsetSummary summary;
  for (const Definition& one : kDefinitions) {
    const bool is_count = one.reduce == nullptr && one.of == nullptr;
    summary.figures.push_back({one.key, one.ofWindows(records, has_truth), is_count});
  }
  for (const Record* record : records) ++summary.statuses[toString(record->answer.status)];
  return summary;
}

}  // namespace

double SubsetSummary::at(const std::string& key) const {
  const auto found = std::find_if(figures.begin(), figures.end(),
                                  [&key](const Figure& figure) { return key == figure.key; });
  return found == figures.end() ? kNotComputed : found->value;
}

std::vector<MethodSummary> summarize(const ProtocolResult& result) {
  std::vector<MethodSummary> summaries;
  for (std::size_t method = 0; method < result.methods.size(); ++method) {
    std::vector<const Record*> all, excited;
    for (const WindowRecord& window : result.windows) {
      all.push_back(&window.methods[method]);
      if (window.excitation.excited) excited.push_back(&window.methods[method]);
    }
    summaries.push_back({result.methods[method], subsetOf(all, result.has_truth),
                         subsetOf(excited, result.has_truth)});
  }
  return summaries;
}

std::string makeReportDirectory(const std::string& directory) {
  std::error_code code;
  fs::create_directories(directory, code);
  if (code || !fs::is_directory(directory, code)) {
    return "directory " + directory + " cannot be made" + (code ? ": " + code.message() : "");
  }
  return "";
}

std::string writeReport(const std::string& directory, const RunInfo& info,
                        const ProtocolResult& result, const std::vector<MethodSummary>& summaries) {
  std::string error = makeReportDirectory(directory);
  const fs::path base(directory);
  if (error.empty()) error = writeFile(base / "windows.csv", windowsCsv(info, result));
  if (error.empty()) error = writeFile(base / "summary.json", summaryJson(info, result, summaries));
  return error;
}

}  // namespace slim_init::evaluation
