// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Statistics over windows, and the files that hold them. Definitions: docs/evaluation.md. Tables,
// pictures and comparisons are made from these files by the Python package in
// slim_init/evaluation/report.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/sequence.h"

namespace slim_init::evaluation {

/// Gravity and gyro bias of windows with one status and without an estimate.
struct PartialSummary {
  int windows = 0;  ///< with a gravity or a gyro bias
  double gravity_median_deg = kNotComputed;
  double gravity_max_deg = kNotComputed;
  double gyro_bias_median_pct = kNotComputed;
  double gyro_bias_max_pct = kNotComputed;
  double gyro_bias_vec_rmse = kNotComputed;  ///< [rad/s]
};

/// One method over one set of windows. A number that does not exist (no successful window, say) is
/// NaN here and null or empty in the files.
struct SubsetSummary {
  int windows = 0;    ///< windows with ground truth
  int attempted = 0;  ///< windows with an estimate, whatever its status
  int success = 0;    ///< attempted windows with |s - 1| < 0.5, whatever the status
  double success_rate = kNotComputed;  ///< success / windows; NaN without ground truth

  // Over successful windows.
  double scale_rmse = kNotComputed;
  double scale_median = kNotComputed;
  double scale_p90 = kNotComputed;
  double gravity_rmse_deg = kNotComputed;
  double gravity_median_deg = kNotComputed;
  double gravity_p90_deg = kNotComputed;
  double velocity_rmse = kNotComputed;       ///< [m/s]
  double velocity_median = kNotComputed;     ///< of the windows' root mean squares [m/s]
  double velocity_p90 = kNotComputed;        ///< likewise
  double velocity_vec_rmse = kNotComputed;   ///< [m/s]
  double pose_rmse = kNotComputed;           ///< [m]
  double pose_median = kNotComputed;         ///< of the windows' root mean squares [m]
  double pose_p90 = kNotComputed;            ///< likewise
  double gyro_bias_err_pct = kNotComputed;   ///< root mean square of the windows' percentages
  double gyro_bias_vec_rmse = kNotComputed;  ///< [rad/s]

  // Over windows that the method accepted (status success).
  int accepted = 0;
  int accepted_within_0_1 = 0;                     ///< |s - 1| < 0.1
  int accepted_within_0_5 = 0;                     ///< |s - 1| < 0.5
  int accepted_beyond_0_25 = 0;                    ///< |s - 1| > 0.25
  double accepted_within_0_1_rate = kNotComputed;  ///< of accepted
  double accepted_within_0_5_rate = kNotComputed;  ///< of accepted
  double accepted_scale_error_max = kNotComputed;
  double accepted_rate = kNotComputed;              ///< of windows
  double accepted_scale_rmse = kNotComputed;        ///< whatever the errors are
  double accepted_scale_median = kNotComputed;      ///< likewise
  double accepted_gravity_rmse_deg = kNotComputed;  ///< likewise
  double accepted_velocity_rmse = kNotComputed;     ///< likewise [m/s]
  // Root mean squares over the accepted estimates that have the number.
  double accepted_scale_over_sigma = kNotComputed;     ///< |s - 1| over the stated scale_sigma
  double accepted_td_rmse_ms = kNotComputed;           ///< td estimated minus true [ms]
  double accepted_td_over_sigma = kNotComputed;        ///< over its stated standard deviation
  double accepted_rotation_rmse_deg = kNotComputed;    ///< angle between the two R_b_c [deg]
  double accepted_rotation_over_sigma = kNotComputed;  ///< per axis, through the covariance
  double accepted_readout_rmse_ms = kNotComputed;      ///< readout time [ms]
  double accept_s_median = kNotComputed;  ///< data from first to last keyframe at acceptance [s]
  double accept_s_p90 = kNotComputed;     ///< likewise, 90 % quantile
  double accept_keyframes_median = kNotComputed;
  /// Accepted estimates with |s - 1| < 0.1: their fraction of all windows, and accept_s over them.
  double right_rate = kNotComputed;
  double right_s_median = kNotComputed;  ///< [s]
  double right_s_p90 = kNotComputed;     ///< [s]

  // Over accepted estimates from which an estimator was run.
  int downstream_runs = 0;
  int downstream_diverged = 0;
  double downstream_divergence_rate = kNotComputed;  ///< of the runs
  double downstream_ate_median = kNotComputed;       ///< over all runs, diverged ones included [m]
  double downstream_ate_p90 = kNotComputed;          ///< likewise [m]
  double downstream_scale_median = kNotComputed;     ///< |s - 1| of the last window, likewise
  double downstream_scale_p90 = kNotComputed;        ///< likewise

  int waiting = 0;                      ///< isWait(status)
  int refused = 0;                      ///< isRefused(status)
  int failed = 0;                       ///< invalid input or numerical failure
  std::map<std::string, int> statuses;  ///< windows by status name; names that occur

  /// What was known in windows without an estimate, by name of the status; names with a number.
  std::map<std::string, PartialSummary> partial;

  // Over attempted windows: an early "wait" is no fast solution.
  double solve_ms_median = kNotComputed;  ///< wall time
  double solve_ms_mean = kNotComputed;
  double solve_cpu_ms_median = kNotComputed;  ///< CPU time of the solving thread
  double solve_cpu_ms_mean = kNotComputed;
  double solve_cpu_ms_p90 = kNotComputed;
};

/// Summary numbers of one method, over all windows and over the excited ones.
struct MethodSummary {
  std::string name;
  SubsetSummary all;
  SubsetSummary excited;
};

/// Statistics of every method, in the order of result.methods.
std::vector<MethodSummary> summarize(const ProtocolResult& result);

using OptionValue = std::variant<std::int64_t, double, std::string, std::vector<std::string>>;

/// A number with a name, for a table of counts.
using NamedCount = std::pair<std::string, std::int64_t>;

/// What was run, for the reader of the files.
struct RunInfo {
  std::string version;  ///< of the program
  std::string commit;   ///< of its source, where known
  std::string dataset;
  std::string command;
  std::string gyro_bias_truth;  ///< "recorded", "fitted", "simulated" or "none"
  std::vector<std::pair<std::string, OptionValue>> options;
  std::vector<std::string> notes;
  std::optional<TrackingSummary> tracking;  ///< where the features come from images
  std::vector<NamedCount> simulated;        ///< what was simulated; empty with images
  /// What a variant of a method changes, by the variant's name; empty without variants.
  std::vector<std::pair<std::string, std::string>> method_notes;
};

/// The files as text.
std::string windowsCsv(const RunInfo& info, const ProtocolResult& result);
std::string summaryCsv(const RunInfo& info, const std::vector<MethodSummary>& summaries);
std::string summaryJson(const RunInfo& info, const ProtocolResult& result,
                        const std::vector<MethodSummary>& summaries);

/// The main table for a terminal, one block per subset, and the statuses.
std::string summaryTable(const ProtocolResult& result, const std::vector<MethodSummary>& summaries);

/// Makes `directory` with its parents. Returns an empty string, or a message naming the path.
std::string makeReportDirectory(const std::string& directory);

/// Writes windows.csv, summary.csv and summary.json into `directory`, which is made when missing.
/// Returns an empty string, or a message naming the file that could not be written.
std::string writeReport(const std::string& directory, const RunInfo& info,
                        const ProtocolResult& result, const std::vector<MethodSummary>& summaries);

}  // namespace slim_init::evaluation
