// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// One sequence through every method, with its report: what `slim_init ab` does once and a suite
// many times.
#pragma once

#include <string>
#include <vector>

#include "ab_options.h"
#include "exit_code.h"
#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/report.h"

namespace slim_init::evaluation {
class WindowJournal;
}

namespace slim_init::tools {

/// Why something was not done; nothing is wrong with kExitOk.
struct Failure {
  ExitCode code = kExitOk;
  std::string sentence;

  explicit operator bool() const { return code != kExitOk; }
};

/// A case that was run: what the files in its folder were written from.
struct CaseResult {
  evaluation::RunInfo info;
  evaluation::ProtocolResult result;
  std::vector<evaluation::MethodSummary> summaries;
};

/// Of the run, without a bearing on its answers.
struct CaseHooks {
  evaluation::WindowJournal* journal = nullptr;  ///< for resuming; null: every window is solved
  std::string label;        ///< of the progress bar, before the sequence's name
  bool print_notes = true;  ///< on the data, to stderr
};

/// Reads the files that the options name and checks everything that can be known before the data
/// are read.
Failure prepareCase(AbOptions* options);

/// Loads or simulates the sequence, runs every method on its windows and writes the report into
/// options.out, pictures included. `options` have been prepared.
Failure runCase(const AbOptions& options, const CaseHooks& hooks, CaseResult* result);

}  // namespace slim_init::tools
