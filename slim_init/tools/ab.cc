// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "ab.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "exit_code.h"
#include "load_sequence.h"
#include "options_file.h"
#include "progress_bar.h"
#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/report.h"
#include "slim_init/window_solver.h"

namespace slim_init::tools {
namespace {

int fail(ExitCode code, const std::string& sentence) {
  std::cerr << "slim_init: " << sentence << "\n";
  return code;
}

std::string noWindowSentence(const LoadedSequence& loaded, const AbOptions& options,
                             const evaluation::ProtocolCounts& counts) {
  std::ostringstream out;
  out << loaded.sequence.name << " holds no window of " << options.keyframes
      << " keyframes: " << counts.trials << " trials over " << counts.frames << " usable frames, "
      << counts.ended << " met the end of the data, " << counts.interrupted << " a gap, "
      << counts.without_truth << " had no truth, " << counts.invalid << " were refused";
  for (const std::string& note : loaded.sequence.notes) out << "; " << note;
  return out.str();
}

}  // namespace

int runAb(AbOptions options) {
  if (!options.options_file.empty()) {
    if (const std::string error = readOptionsFile(&options); !error.empty()) {
      return fail(kExitBadInput, error);
    }
  }
  if (const std::string error = checkAbOptions(&options); !error.empty()) {
    return fail(kExitBadInput, error);
  }

  // The methods.
  std::vector<std::unique_ptr<WindowSolver>> solvers;
  std::vector<const WindowSolver*> solver_list;
  for (const std::string& name : options.method_names) {
    std::string error;
    solvers.push_back(makeWindowSolver(name, options.initializer, &error));
    if (solvers.back() == nullptr) return fail(kExitInternal, error);
    solver_list.push_back(solvers.back().get());
  }

  // The data.
  LoadedSequence loaded;
  if (const std::string error = loadSequence(options, &loaded); !error.empty()) {
    return fail(kExitBadInput, error);
  }
  std::vector<std::string> notes = options.file_notes;
  notes.insert(notes.end(), loaded.sequence.notes.begin(), loaded.sequence.notes.end());
  for (const std::string& note : notes) {
    std::cerr << "slim_init: note: " << note << "\n";
  }
  // Before the long part: a report that cannot be written is best known now.
  if (const std::string error = evaluation::makeReportDirectory(options.out); !error.empty()) {
    return fail(kExitInternal, "--out: " + error);
  }

  // Every method on the same windows.
  evaluation::ProtocolOptions protocol;
  protocol.stride = options.stride;
  protocol.max_windows = options.limit;
  protocol.window = options.initializer.window;
  evaluation::ProtocolResult result;
  {
    ProgressBar bar(loaded.sequence.name, !options.quiet);
    const std::string error = evaluation::runProtocol(
        loaded.sequence, solver_list, protocol,
        [&bar](int done, int total) { bar.update(done, total); }, &result);
    if (!error.empty()) return fail(kExitInternal, error);
  }
  if (result.windows.empty()) {
    return fail(kExitBadInput, noWindowSentence(loaded, options, result.counts));
  }

  // The report.
  evaluation::RunInfo info;
  info.dataset = loaded.sequence.name;
  info.command = options.command;
  info.gyro_bias_truth = loaded.gyro_bias_truth;
  info.options = describeAbOptions(options);
  info.notes = notes;
  const std::vector<evaluation::MethodSummary> summaries = evaluation::summarize(result);
  if (const std::string error = evaluation::writeReport(options.out, info, result, summaries);
      !error.empty()) {
    return fail(kExitInternal, error);
  }
  if (!options.quiet) {
    std::cout << info.dataset << " (" << options.world << ", seed " << options.seed << ")\n"
              << evaluation::summaryTable(summaries)
              << "\nReport: " << (std::filesystem::path(options.out) / "report.md").string()
              << "\n";
  }
  return kExitOk;
}

}  // namespace slim_init::tools
