// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Where the program meets the Python package of slim_init/evaluation/report: nowhere else.
#pragma once

#include <string>
#include <vector>

#include "exit_code.h"

namespace slim_init::tools {

/// What came of a report.
struct ReportOutcome {
  ExitCode code = kExitOk;
  bool written = false;
  std::string message;  ///< why there is none; a missing python is no failure: code stays kExitOk
};

/// Writes report.md and report.html into `directory`, which holds the data of a run.
ReportOutcome makeReport(const std::string& directory);

/// `slim_init report ARGUMENTS`: hands them to the package. Returns its exit code.
int runReport(const std::vector<std::string>& arguments);

/// The file of the Snakemake workflow that runs the paper's cases, as it is found from here.
std::string suiteFile();

}  // namespace slim_init::tools
