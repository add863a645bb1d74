// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "ab.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "ablation.h"
#include "exit_code.h"
#include "load_sequence.h"
#include "options_file.h"
#include "plots.h"
#include "progress_bar.h"
#ifdef SLIM_INIT_HAS_BACKEND
#include "slim_init/backend/downstream.h"
#endif
#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/report.h"
#include "slim_init/window_solver.h"
#include "source_commit.h"

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

std::string trackingLine(const evaluation::TrackingSummary& tracking) {
  std::ostringstream out;
  out.precision(3);
  out << tracking.tracked << " of " << tracking.images << " images tracked; an image has "
      << tracking.points << " points and " << tracking.lines << " lines, "
      << tracking.points_carried << " and " << tracking.lines_carried
      << " of them from the image before; front end " << tracking.total_ms_median
      << " ms (medians)\n";
  return out.str();
}

/// The back end of --downstream; false where this program was built without it.
bool setDownstream(const AbOptions& options, evaluation::ProtocolOptions* protocol) {
  if (!(options.downstream_s > 0.0)) return true;
#ifdef SLIM_INIT_HAS_BACKEND
  backend::DownstreamOptions downstream;
  downstream.seconds = options.downstream_s;
  protocol->downstream = [downstream](const evaluation::Sequence& sequence,
                                      const InitResult& answer) {
    return backend::runDownstream(sequence, answer, downstream);
  };
  return true;
#else
  (void)protocol;
  return false;
#endif
}

}  // namespace

int runAb(AbOptions options) {
  if (options.hasFile()) {
    if (const std::string error = readConfiguration(&options); !error.empty()) {
      return fail(kExitBadInput, error);
    }
  }
  if (const std::string error = checkAbOptions(&options); !error.empty()) {
    return fail(kExitBadInput, error);
  }

  // The methods.
  std::vector<Method> methods;
  if (const std::string error = makeMethods(options, &methods); !error.empty()) {
    return fail(kExitInternal, error);
  }
  std::vector<const WindowSolver*> solver_list;
  for (const Method& method : methods) solver_list.push_back(method.solver.get());

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
  protocol.first_keyframes = options.first_keyframes;
  if (!setDownstream(options, &protocol)) {
    return fail(kExitBadInput,
                "--downstream: this program was built without the back end, which needs Ceres "
                "Solver (libceres-dev)");
  }
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
  const std::vector<evaluation::MethodSummary> summaries = evaluation::summarize(result);
  if (const std::string error = evaluation::writeReport(options.out, info, result, summaries);
      !error.empty()) {
    return fail(kExitInternal, error);
  }
  if (options.plots == "auto") {
    drawPlots(options.out, &info);
    if (const std::string error = evaluation::writeReportPage(options.out, info, result, summaries);
        !error.empty()) {
      return fail(kExitInternal, error);
    }
  }
  if (!options.quiet) {
    std::cout << info.dataset;
    if (!options.hasImages())
      std::cout << " (" << options.world << ", seed " << options.seed << ")";
    std::cout << "\n";
    if (info.tracking.has_value()) std::cout << trackingLine(*info.tracking);
    std::cout << evaluation::summaryTable(result, summaries)
              << "\nReport: " << (std::filesystem::path(options.out) / "report.md").string()
              << "\n";
  }
  return kExitOk;
}

}  // namespace slim_init::tools
