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

/// Writes report.md and report.html into `directory`, which holds the data of a run; the page of
/// the demo from the two folders of `demo`.
ReportOutcome makeReport(const std::string& directory, const std::vector<std::string>& demo = {});

/// `slim_init report ARGUMENTS`: hands them to the package. Returns its exit code.
int runReport(const std::vector<std::string>& arguments);

}  // namespace slim_init::tools
