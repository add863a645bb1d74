// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "ab.h"

#include <filesystem>
#include <iostream>
#include <sstream>
#include <string>
#include <utility>

#include "run_case.h"
#include "suite.h"

namespace slim_init::tools {
namespace {

int fail(const Failure& failure) {
  std::cerr << "slim_init: " << failure.sentence << "\n";
  return failure.code;
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

}  // namespace

int runAb(AbOptions options) {
  if (options.given.count("suite") > 0) return runSuite(std::move(options));
  if (const Failure failure = prepareCase(&options)) return fail(failure);
  CaseResult run;
  if (const Failure failure = runCase(options, CaseHooks(), &run)) return fail(failure);
  if (options.quiet) return kExitOk;
  std::cout << run.info.dataset;
  if (!options.hasImages()) std::cout << " (" << options.world << ", seed " << options.seed << ")";
  std::cout << "\n";
  if (run.info.tracking.has_value()) std::cout << trackingLine(*run.info.tracking);
  std::cout << evaluation::summaryTable(run.result, run.summaries)
            << "\nReport: " << (std::filesystem::path(options.out) / "report.md").string() << "\n";
  return kExitOk;
}

}  // namespace slim_init::tools
