// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "run_case.h"

#include <iostream>
#include <memory>
#include <sstream>

#include "ablation.h"
#include "load_sequence.h"
#include "options_file.h"
#include "plots.h"
#include "progress_bar.h"
#ifdef SLIM_INIT_HAS_BACKEND
#include "slim_init/backend/downstream.h"
#endif
#include "slim_init/window_solver.h"
#include "source_commit.h"

namespace slim_init::tools {
namespace {

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

/// The back end of --downstream.
void setDownstream(const AbOptions& options, evaluation::ProtocolOptions* protocol) {
#ifdef SLIM_INIT_HAS_BACKEND
  if (!(options.downstream_s > 0.0)) return;
  backend::DownstreamOptions downstream;
  downstream.seconds = options.downstream_s;
  protocol->downstream = [downstream](const evaluation::Sequence& sequence,
                                      const InitResult& answer) {
    return backend::runDownstream(sequence, answer, downstream);
  };
#else
  (void)options;
  (void)protocol;
#endif
}

/// What was run, but for the pictures, which come last.
evaluation::RunInfo describeRun(const AbOptions& options, const LoadedSequence& loaded,
                                const std::vector<Method>& methods,
                                const std::vector<std::string>& notes) {
  evaluation::RunInfo info;
  info.version = SLIM_INIT_VERSION;
  info.commit = sourceCommit();
  info.dataset = loaded.sequence.name;
  info.command = options.command;
  info.gyro_bias_truth = loaded.gyro_bias_truth;
  info.options = describeAbOptions(options);
  info.notes = notes;
  for (const Method& method : methods) {
    if (!method.note.empty()) info.method_notes.emplace_back(method.solver->name(), method.note);
  }
  info.tracking = loaded.sequence.tracking;
  if (loaded.simulated.has_value()) {
    const simulation::FeatureSimulationCounts& counts = *loaded.simulated;
    info.simulated = {{"point_tracks", counts.point_tracks},
                      {"outlier_tracks", counts.outlier_tracks},
                      {"line_tracks", counts.line_tracks},
                      {"fragmented_lines", counts.fragmented_lines},
                      {"misassociated_lines", counts.misassociated_lines}};
  }
  return info;
}

}  // namespace

Failure prepareCase(AbOptions* options) {
  if (options->hasFile()) {
    if (std::string error = readConfiguration(options); !error.empty()) {
      return {kExitBadInput, error};
    }
  }
  if (std::string error = checkAbOptions(options); !error.empty()) return {kExitBadInput, error};
#ifndef SLIM_INIT_HAS_BACKEND
  if (options->downstream_s > 0.0) {
    return {kExitBadInput,
            "--downstream: this program was built without the back end, which needs Ceres Solver "
            "(libceres-dev)"};
  }
#endif
  return {};
}

Failure runCase(const AbOptions& options, const CaseHooks& hooks, CaseResult* result) {
  // The methods.
  std::vector<Method> methods;
  if (std::string error = makeMethods(options, &methods); !error.empty()) {
    return {kExitInternal, error};
  }
  std::vector<const WindowSolver*> solver_list;
  for (const Method& method : methods) solver_list.push_back(method.solver.get());

  // The data.
  LoadedSequence loaded;
  if (std::string error = loadSequence(options, &loaded); !error.empty()) {
    return {kExitBadInput, error};
  }
  std::vector<std::string> notes = options.file_notes;
  notes.insert(notes.end(), loaded.sequence.notes.begin(), loaded.sequence.notes.end());
  if (hooks.print_notes) {
    for (const std::string& note : notes) std::cerr << "slim_init: note: " << note << "\n";
  }
  // Before the long part: a report that cannot be written is best known now.
  if (std::string error = evaluation::makeReportDirectory(options.out); !error.empty()) {
    return {kExitInternal, "--out: " + error};
  }

  // Every method on the same windows.
  evaluation::ProtocolOptions protocol;
  protocol.stride = options.stride;
  protocol.max_windows = options.limit;
  protocol.imu = options.initializer.imu;
  protocol.window = options.initializer.window;
  protocol.first_keyframes = options.first_keyframes;
  protocol.threads = options.threads;
  protocol.downstream_every = options.downstream_every;
  protocol.journal = hooks.journal;
  setDownstream(options, &protocol);
  {
    ProgressBar bar(hooks.label + loaded.sequence.name, !options.quiet);
    if (std::string error = evaluation::runProtocol(
            loaded.sequence, solver_list, protocol,
            [&bar](int done, int total) { bar.update(done, total); }, &result->result);
        !error.empty()) {
      return {kExitInternal, error};
    }
  }
  if (result->result.windows.empty()) {
    return {kExitBadInput, noWindowSentence(loaded, options, result->result.counts)};
  }

  // The report.
  result->info = describeRun(options, loaded, methods, notes);
  result->summaries = evaluation::summarize(result->result);
  if (std::string error =
          evaluation::writeReport(options.out, result->info, result->result, result->summaries);
      !error.empty()) {
    return {kExitInternal, error};
  }
  if (options.plots == "auto") {
    drawPlots(options.out, &result->info);
    if (std::string error = evaluation::writeReportPage(options.out, result->info, result->result,
                                                        result->summaries);
        !error.empty()) {
      return {kExitInternal, error};
    }
  }
  return {};
}

}  // namespace slim_init::tools
