// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/report.h"

#include <cmath>
#include <filesystem>

#include "slim_init/evaluation/statistics.h"
#include "slim_init/evaluation/write_file.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;

double ratio(int part, int whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : kNotComputed;
}

/// Adds the windows of one method one by one.
class SubsetCollector {
 public:
  void add(const MethodRecord& record) {
    ++summary_.windows;
    ++summary_.statuses[toString(record.status)];
    if (record.attempted) {
      ++summary_.attempted;
      solve_ms_.push_back(record.solve_ms);
      solve_cpu_ms_.push_back(record.solve_cpu_ms);
    }
    if (record.accepted()) {
      addAccepted(record);
      addDownstream(record.downstream);
    } else if (isWait(record.status)) {
      ++summary_.waiting;
    } else if (isRefused(record.status)) {
      ++summary_.refused;
    } else {
      ++summary_.failed;
    }
    if (record.attempted && record.metrics.success()) addSuccess(record.metrics);
    if (!record.attempted) addPartial(toString(record.status), record.partial);
  }

  SubsetSummary summary(bool has_truth) const {
    SubsetSummary s = summary_;
    if (has_truth) s.success_rate = ratio(s.success, s.windows);
    s.scale_rmse = rootMeanSquare(scale_);
    s.scale_median = median(scale_);
    s.scale_p90 = quantile(scale_, 0.9);
    s.gravity_rmse_deg = rootMeanSquare(gravity_);
    s.gravity_median_deg = median(gravity_);
    s.gravity_p90_deg = quantile(gravity_, 0.9);
    s.velocity_rmse = rootMeanSquare(velocity_);
    s.velocity_median = median(velocity_);
    s.velocity_p90 = quantile(velocity_, 0.9);
    s.velocity_vec_rmse = rootMeanSquare(velocity_vec_);
    s.pose_rmse = rootMeanSquare(pose_);
    s.pose_median = median(pose_);
    s.pose_p90 = quantile(pose_, 0.9);
    s.gyro_bias_err_pct = rootMeanSquare(gyro_bias_pct_);
    s.gyro_bias_vec_rmse = rootMeanSquare(gyro_bias_vec_);
    s.accepted_rate = ratio(s.accepted, s.windows);
    s.accept_s_median = median(accept_s_);
    s.accept_s_p90 = quantile(accept_s_, 0.9);
    s.accept_keyframes_median = median(accept_keyframes_);
    s.right_s_median = median(right_s_);
    s.right_s_p90 = quantile(right_s_, 0.9);
    s.accepted_scale_rmse = rootMeanSquare(accepted_scale_);
    s.accepted_scale_median = median(accepted_scale_);
    s.accepted_gravity_rmse_deg = rootMeanSquare(accepted_gravity_);
    s.accepted_velocity_rmse = rootMeanSquare(accepted_velocity_);
    s.accepted_scale_over_sigma = rootMeanSquare(scale_over_sigma_);
    s.accepted_td_rmse_ms = rootMeanSquare(td_ms_);
    s.accepted_td_over_sigma = rootMeanSquare(td_over_sigma_);
    s.accepted_rotation_rmse_deg = rootMeanSquare(rotation_deg_);
    s.accepted_rotation_over_sigma = rootMeanSquare(rotation_over_sigma_);
    s.accepted_readout_rmse_ms = rootMeanSquare(readout_ms_);
    s.downstream_divergence_rate = ratio(s.downstream_diverged, s.downstream_runs);
    s.downstream_ate_median = median(downstream_ate_);
    s.downstream_ate_p90 = quantile(downstream_ate_, 0.9);
    s.downstream_scale_median = median(downstream_scale_);
    s.downstream_scale_p90 = quantile(downstream_scale_, 0.9);
    if (has_truth) {
      s.accepted_within_0_1_rate = ratio(s.accepted_within_0_1, s.accepted);
      s.accepted_within_0_5_rate = ratio(s.accepted_within_0_5, s.accepted);
      s.right_rate = ratio(s.accepted_within_0_1, s.windows);
    }
    for (const auto& [status, errors] : partial_) {
      PartialSummary& partial = s.partial[status];
      partial.windows = errors.windows;
      partial.gravity_median_deg = median(errors.gravity);
      partial.gravity_max_deg = quantile(errors.gravity, 1.0);
      partial.gyro_bias_median_pct = median(errors.bias_pct);
      partial.gyro_bias_max_pct = quantile(errors.bias_pct, 1.0);
      partial.gyro_bias_vec_rmse = rootMeanSquare(errors.bias_vec);
    }
    s.solve_ms_median = median(solve_ms_);
    s.solve_ms_mean = mean(solve_ms_);
    s.solve_cpu_ms_median = median(solve_cpu_ms_);
    s.solve_cpu_ms_mean = mean(solve_cpu_ms_);
    s.solve_cpu_ms_p90 = quantile(solve_cpu_ms_, 0.9);
    return s;
  }

 private:
  void addAccepted(const MethodRecord& record) {
    ++summary_.accepted;
    accept_s_.push_back(record.data_s);
    accept_keyframes_.push_back(record.keyframes);
    if (!record.metrics.computed()) return;
    const double scale_error = record.metrics.scale_error;
    accepted_scale_.push_back(scale_error);
    accepted_gravity_.push_back(record.metrics.gravity_error_deg);
    accepted_velocity_.push_back(record.metrics.velocity_rmse);
    addFinite(scale_error / record.scale_sigma, &scale_over_sigma_);
    addFinite(1e3 * record.calibration.td_s, &td_ms_);
    addFinite(record.calibration.tdOverSigma(), &td_over_sigma_);
    addFinite(record.calibration.rotation_deg, &rotation_deg_);
    addFinite(record.calibration.rotation_over_sigma, &rotation_over_sigma_);
    addFinite(1e3 * record.calibration.readout_s, &readout_ms_);
    if (scale_error < 0.1) {
      ++summary_.accepted_within_0_1;
      right_s_.push_back(record.data_s);
    }
    if (scale_error > 0.25) ++summary_.accepted_beyond_0_25;
    if (scale_error < 0.5) ++summary_.accepted_within_0_5;
    // Written so that the first window replaces the NaN.
    if (!(summary_.accepted_scale_error_max >= scale_error)) {
      summary_.accepted_scale_error_max = scale_error;
    }
  }

  static void addFinite(double value, std::vector<double>* values) {
    if (std::isfinite(value)) values->push_back(value);
  }

  void addDownstream(const DownstreamRecord& record) {
    if (!record.ran) return;
    ++summary_.downstream_runs;
    summary_.downstream_diverged += record.diverged ? 1 : 0;
    if (std::isfinite(record.ate)) downstream_ate_.push_back(record.ate);
    if (std::isfinite(record.scale_error)) downstream_scale_.push_back(record.scale_error);
  }

  void addSuccess(const WindowMetrics& metrics) {
    ++summary_.success;
    scale_.push_back(metrics.scale_error);
    gravity_.push_back(metrics.gravity_error_deg);
    velocity_.push_back(metrics.velocity_rmse);
    velocity_vec_.push_back(metrics.velocity_vec_rmse);
    pose_.push_back(metrics.pose_rmse);
    gyro_bias_vec_.push_back(metrics.gyro_bias_vec_err);
    // Does not exist for a true bias of zero.
    if (std::isfinite(metrics.gyro_bias_err_pct)) {
      gyro_bias_pct_.push_back(metrics.gyro_bias_err_pct);
    }
  }

  void addPartial(const std::string& status, const PartialMetrics& metrics) {
    const bool gravity = std::isfinite(metrics.gravity_error_deg);
    const bool bias = std::isfinite(metrics.gyro_bias_vec_err);
    if (!gravity && !bias) return;
    PartialErrors& errors = partial_[status];
    ++errors.windows;
    if (gravity) errors.gravity.push_back(metrics.gravity_error_deg);
    if (bias) errors.bias_vec.push_back(metrics.gyro_bias_vec_err);
    if (std::isfinite(metrics.gyro_bias_err_pct)) {
      errors.bias_pct.push_back(metrics.gyro_bias_err_pct);
    }
  }

  struct PartialErrors {
    int windows = 0;
    std::vector<double> gravity, bias_pct, bias_vec;
  };

  SubsetSummary summary_;
  std::map<std::string, PartialErrors> partial_;
  std::vector<double> scale_, gravity_, velocity_, velocity_vec_, pose_;
  std::vector<double> gyro_bias_pct_, gyro_bias_vec_, solve_ms_, solve_cpu_ms_;
  std::vector<double> accept_s_, accept_keyframes_, right_s_;
  std::vector<double> downstream_ate_, downstream_scale_;
  std::vector<double> accepted_scale_, accepted_gravity_, accepted_velocity_;
  std::vector<double> scale_over_sigma_, td_ms_, td_over_sigma_;
  std::vector<double> rotation_deg_, rotation_over_sigma_, readout_ms_;
};

}  // namespace

std::vector<MethodSummary> summarize(const ProtocolResult& result) {
  std::vector<MethodSummary> summaries;
  for (std::size_t method = 0; method < result.methods.size(); ++method) {
    SubsetCollector all;
    SubsetCollector excited;
    for (const WindowRecord& window : result.windows) {
      all.add(window.methods[method]);
      if (window.excitation.excited) excited.add(window.methods[method]);
    }
    summaries.push_back(
        {result.methods[method], all.summary(result.has_truth), excited.summary(result.has_truth)});
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
  if (error.empty()) error = writeFile(base / "summary.csv", summaryCsv(info, summaries));
  if (error.empty()) error = writeFile(base / "summary.json", summaryJson(info, result, summaries));
  return error;
}

}  // namespace slim_init::evaluation
