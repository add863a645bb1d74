// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What `slim_init ab --suite paper` runs.
#pragma once

#include <string>
#include <vector>

#include "ab_options.h"

namespace slim_init::tools {

/// Where a case's data come from.
enum class CaseKind {
  kImages,    ///< EuRoC, points and lines tracked through its images
  kRecorded,  ///< recorded motion and IMU, simulated features
  kBuiltin,   ///< simulated motion, IMU and features
};

/// One run of `slim_init ab`.
struct SuiteCase {
  std::string name;  ///< "V1_01"; of a kind each name is there once, of ablations once more
  CaseKind kind = CaseKind::kBuiltin;
  std::string
      group;  ///< "Machine Hall", "Vicon Room 1", .., "Degenerate", "Without parallax", "Excited"
  std::string paper_column;  ///< sequence of the paper's table I; empty: not in it
  bool ablation = false;     ///< the methods with one ingredient changed at a time
  AbOptions options;         ///< as typed for this case alone; options.out is its folder

  bool degenerate() const;       ///< scale is hard to see
  bool withoutParallax() const;  ///< there is no scale to be seen
  std::string folder() const;    ///< relative to --out: "recorded/V1_01"
  std::string feature() const;   ///< what it is, in words: "corridor, 12 points, 25 lines"
};

struct Suite {
  std::vector<SuiteCase> cases;
  std::vector<std::string> notes;  ///< what was looked for and is not there
};

/// Checks the options of --suite against each other. Returns an empty string, or a sentence.
std::string checkSuiteOptions(const AbOptions& options);

/// The cases, in the order of the reports. `options` have passed checkSuiteOptions(). Returns an
/// empty string, or a sentence naming a folder that holds nothing to run.
std::string listSuiteCases(const AbOptions& options, Suite* suite);

/// The command that runs this case alone.
std::string caseCommand(const AbOptions& options);

}  // namespace slim_init::tools
