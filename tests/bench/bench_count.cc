// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <boost/program_options.hpp>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>

#include "ab_options.h"
#include "bench_commands.h"
#include "bench_windows.h"
#include "methods.h"
#include "slim_init/evaluation/protocol.h"
#include "slim_init/options.h"
#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#endif

namespace slim_init::tools {
namespace {

namespace po = boost::program_options;

using Windows = std::vector<std::shared_ptr<const InitWindow>>;

Windows windowsOf(BenchWindows what, const std::vector<std::string>& recorded) {
  Windows all;
  for (const std::string& folder : recorded) {
    what.recorded = folder;
    const Windows some = cutWindows(benchSequence(what), what);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

// A name of its own, so that an instrumenting tool can restrict itself to it.
__attribute__((noinline)) std::size_t countedSolves(const WindowSolver& solver,
                                                    const Windows& windows) {
#ifdef CALLGRIND_START_INSTRUMENTATION
  CALLGRIND_START_INSTRUMENTATION;
#endif
  std::size_t answered = 0;
  for (const auto& window : windows) answered += solver.solve(*window).hasEstimate() ? 1 : 0;
#ifdef CALLGRIND_STOP_INSTRUMENTATION
  CALLGRIND_STOP_INSTRUMENTATION;
#endif
  return answered;
}

// Answers with all their digits, so that two builds can be compared.
std::string writeAnswers(const std::string& file, const WindowSolver& solver,
                         const Windows& windows) {
  std::ofstream out(file, std::ios::app);
  out.precision(17);
  for (const auto& window : windows) {
    const InitResult result = solver.solve(*window);
    out << solver.name() << ',' << window->times().front() << ',' << toString(result.status) << ','
        << result.scale << ',' << result.scale_sigma;
    for (const Eigen::Vector3d& v : {result.gyro_bias, result.accel_bias, result.gravity_b0}) {
      out << ',' << v.x() << ',' << v.y() << ',' << v.z();
    }
    const Eigen::Vector3d v =
        result.states.empty() ? Eigen::Vector3d::Zero().eval() : result.states.back().v_w_b;
    out << ',' << v.x() << ',' << v.y() << ',' << v.z() << '\n';
  }
  return out.good() ? "" : file + " cannot be written";
}

}  // namespace

int runCountCommand(const std::vector<std::string>& arguments) {
  std::vector<std::string> recorded;
  std::string methods = "drt-l,slim", answers;
  BenchWindows what;
  po::options_description table("slim_init_bench count, options");
  addSequenceOptions(&recorded, &what, &table);
  auto add = table.add_options();
  add("methods", po::value(&methods)->default_value(methods), "comma separated");
  add("drift", po::value(&what.drift)->default_value(what.drift),
      "random walk of a point track, per image and axis [px]");
  add("windows", po::value(&what.limit)->default_value(what.limit),
      "maximum number for each sequence");
  add("answers", po::value(&answers), "file to which all estimates are appended");
  if (const auto code = readOptions(table, arguments)) return *code;
  if (recorded.empty()) recorded.push_back("");
  const Windows windows = windowsOf(what, recorded);
  InitializerOptions options;
  options.window.keyframes = options.window.min_keyframes = evaluation::paperWindow().keyframes;
  for (const std::string& name : splitList(methods)) {
    std::string problem;
    const auto solver = baselines::makeMethod(name, options, {}, &problem, baselines::allMethods());
    if (solver != nullptr && !answers.empty()) problem = writeAnswers(answers, *solver, windows);
    if (!problem.empty()) {
      std::cerr << "slim_init_bench: " << problem << "\n";
      return 1;
    }
    // Tables that are made by the first solve are not counted.
    solver->solve(*windows.front());
    std::printf("%s %zu windows %zu solved\n", name.c_str(), windows.size(),
                countedSolves(*solver, windows));
  }
  return 0;
}

}  // namespace slim_init::tools
