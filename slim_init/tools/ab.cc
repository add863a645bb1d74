// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "ab_options.h"
#include "exit_code.h"
#include "load_sequence.h"
#include "methods.h"
#include "progress_bar.h"
#include "python_report.h"
#include "slim_init/backend/downstream.h"
#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/report.h"
#include "slim_init/evaluation/write_file.h"
#include "slim_init/text.h"
#include "slim_init/version.h"
#include "subcommand.h"

namespace slim_init::tools {
namespace {

namespace fs = std::filesystem;

std::string trackingLine(const evaluation::TrackingSummary& tracking) {
  return roundedText(3, tracking.tracked, " of ", tracking.images, " images tracked; an image has ",
                     tracking.points, " points and ", tracking.lines, " lines, ",
                     tracking.points_carried, " and ", tracking.lines_carried,
                     " of them from the image before; front end ", tracking.total_ms_median,
                     " ms (medians)\n");
}

std::string noWindowMessage(const LoadedSequence& loaded, const AbOptions& options,
                            const evaluation::ProtocolCounts& counts) {
  std::string message =
      text(loaded.sequence.name, " holds no window of ", options.keyframes,
           " keyframes: ", counts.trials, " trials over ", counts.frames, " usable frames, ",
           counts.ended, " met the end of the data, ", counts.interrupted, " a gap, ",
           counts.without_truth, " had no ground truth, ", counts.not_evaluable,
           " none at the times of an estimate, ", counts.invalid, " were refused");
  for (const std::string& note : loaded.sequence.notes) message += "; " + note;
  return message;
}

/// What was run.
evaluation::RunInfo describeRun(const AbOptions& options, const LoadedSequence& loaded,
                                const std::vector<Method>& methods,
                                const std::vector<std::string>& notes) {
  evaluation::RunInfo info;
  info.version = kVersion;
  info.commit = SLIM_INIT_COMMIT;
  info.dataset = loaded.sequence.name;
  info.command = options.command;
  info.gyro_bias_truth = loaded.gyro_bias_truth;
  info.options = describeAbOptions(options);
  info.notes = notes;
  for (const Method& method : methods) {
    if (!method.note.empty()) info.method_notes[method.name] = method.note;
  }
  info.tracking = loaded.sequence.tracking;
  if (loaded.simulated.has_value()) {
    const simulation::FeatureSimulationCounts& counts = *loaded.simulated;
    info.simulated = {{"point_tracks", counts.point_tracks},
                      {"outlier_tracks", counts.outlier_tracks},
                      {"line_tracks", counts.line_tracks}};
  }
  return info;
}

evaluation::ProtocolOptions protocolOptions(const AbOptions& options) {
  evaluation::ProtocolOptions protocol;
  protocol.stride = options.stride;
  protocol.max_windows = options.limit;
  protocol.imu = options.initializer.imu;
  protocol.window = options.initializer.window;
  protocol.first_keyframes = options.first_keyframes;
  protocol.threads = options.threads;
  protocol.rig = options.rig;
  if (options.downstream_s > 0.0) {
    protocol.downstream = [seconds = options.downstream_s](const evaluation::Sequence& sequence,
                                                           const Calibration& calibration,
                                                           const InitResult& answer) {
      return backend::runDownstream(sequence, calibration, answer, seconds);
    };
  }
  return protocol;
}

/// Every method on the same windows.
evaluation::ProtocolResult solveWindows(const AbOptions& options, const LoadedSequence& loaded,
                                        const std::vector<Method>& methods) {
  std::vector<const WindowSolver*> solvers;
  for (const Method& method : methods) solvers.push_back(method.solver.get());
  ProgressBar bar(loaded.sequence.name, !options.quiet);
  auto result = evaluation::runProtocol(loaded.sequence, solvers, protocolOptions(options),
                                        [&bar](int done, int total) { bar.update(done, total); });
  // The solver of a variant has the name of its method.
  std::transform(methods.begin(), methods.end(), result.methods.begin(),
                 [](const Method& method) { return method.name; });
  return result;
}

int runAb(AbOptions options) {
  readConfiguration(&options);
  checkAbOptions(&options);
  const std::vector<Method> methods = makeMethods(options);
  const LoadedSequence loaded = loadSequence(options);
  std::vector<std::string> notes = options.file_notes;
  notes.insert(notes.end(), loaded.sequence.notes.begin(), loaded.sequence.notes.end());
  for (const std::string& note : notes) std::cerr << "slim_init: note: " << note << "\n";
  std::error_code ignored;
  const bool is_new = !fs::exists(options.out, ignored);
  // Before the long part: a folder that cannot be written is best known now.
  check(evaluation::makeReportDirectory(options.out), "--out: ", kExitInternal);
  const evaluation::ProtocolResult result = solveWindows(options, loaded, methods);
  if (result.windows.empty()) {
    if (is_new) fs::remove(options.out, ignored);
    check(noWindowMessage(loaded, options, result.counts));
  }
  const std::vector<evaluation::MethodSummary> summaries = evaluation::summarize(result);
  check(evaluation::writeReport(options.out, describeRun(options, loaded, methods, notes), result,
                                summaries),
        "", kExitInternal);
  if (!options.quiet) {
    std::cout << loaded.sequence.name;
    if (!options.hasImages()) {
      std::cout << " (" << options.world << ", seed " << options.seed << ")";
    }
    std::cout << "\n";
    if (loaded.sequence.tracking.has_value()) std::cout << trackingLine(*loaded.sequence.tracking);
    std::cout << evaluation::summaryTable(result, summaries) << std::flush;
  }
  ReportOutcome report;
  if (options.report == "auto") report = makeReport(options.out);
  if (report.code != kExitOk) throw Failure(report.code, report.message);
  if (!report.message.empty()) std::cerr << "slim_init: note: " << report.message << "\n";
  if (!options.quiet) {
    const char* name = report.written ? "report.md" : "summary.json";
    std::cout << (report.written ? "\nReport: " : "\nData: ")
              << (fs::path(options.out) / name).string() << "\n";
  }
  return kExitOk;
}

}  // namespace

Subcommand abSubcommand() {
  const auto options = std::make_shared<AbOptions>();
  return {"ab", "Compare initializers on identical windows", abOptionTable(options.get()),
          [options](const Typed& typed) {
            options->command = typed.command;
            options->given = typed.options;
            return runAb(*options);
          }};
}

}  // namespace slim_init::tools
