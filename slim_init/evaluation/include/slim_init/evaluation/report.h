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

/// A number under its key in the files (docs/evaluation.md, "What is counted").
struct Figure {
  const char* key = "";
  double value = kNotComputed;
  bool is_count = false;
};

/// One method over one set of windows. A number that does not exist (no successful window, say) is
/// NaN here and null or empty in the files.
struct SubsetSummary {
  std::vector<Figure> figures;          ///< every key, always in the same order
  std::map<std::string, int> statuses;  ///< windows by status name; names that occur

  /// The value under a key; NaN under a key that does not exist.
  double at(const std::string& key) const;
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

/// What was run, for the reader of the files.
struct RunInfo {
  std::string version;  ///< of the program
  std::string commit;   ///< of its source, where known
  std::string dataset;
  std::string command;
  std::string gyro_bias_truth;  ///< "recorded", "fitted", "simulated" or "none"
  std::vector<std::pair<std::string, OptionValue>> options;
  std::vector<std::string> notes;
  std::optional<TrackingSummary> tracking;        ///< where the features come from images
  std::map<std::string, std::int64_t> simulated;  ///< what was simulated; empty with images
  /// What a variant of a method changes, by the variant's name; empty without variants.
  std::map<std::string, std::string> method_notes;
};

/// The files as text.
std::string windowsCsv(const RunInfo& info, const ProtocolResult& result);
std::string summaryJson(const RunInfo& info, const ProtocolResult& result,
                        const std::vector<MethodSummary>& summaries);

/// The main table for a terminal, one block per subset, and the statuses.
std::string summaryTable(const ProtocolResult& result, const std::vector<MethodSummary>& summaries);

/// Makes `directory` with its parents. Returns an empty string, or a message naming the path.
std::string makeReportDirectory(const std::string& directory);

/// Writes windows.csv and summary.json into `directory`, which is made when missing.
/// Returns an empty string, or a message naming the file that could not be written.
std::string writeReport(const std::string& directory, const RunInfo& info,
                        const ProtocolResult& result, const std::vector<MethodSummary>& summaries);

}  // namespace slim_init::evaluation
