// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>

#include "bench_commands.h"
#include "bench_windows.h"
#include "methods.h"
#include "slim_init/evaluation/cpu_time.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/options.h"
#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#endif

namespace slim_init::tools {
namespace {

namespace po = boost::program_options;

// What every method is compared with, and what the bench is about.
constexpr char kReference[] = "drt-l";
constexpr char kSteps[] = "steps 1 and 2";

using Windows = std::vector<std::shared_ptr<const InitWindow>>;

struct Command {
  std::string name;
  std::vector<std::string> recorded;  // folders; empty: the built-in motion
  std::string methods = "drt-l,slim";
  BenchWindows windows;
  int rounds = 5;
  std::string answers;  // file for the answers of `count`; empty: none
};

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> out;
  std::istringstream stream(list);
  for (std::string item; std::getline(stream, item, ',');) out.push_back(item);
  return out;
}

// Of every window the median over the rounds, so that what remains is how windows differ and not
// what the machine did besides.
class WindowTimes {
 public:
  explicit WindowTimes(std::size_t windows) : rounds_(windows) {}
  void add(std::size_t window, double ms) { rounds_[window].push_back(ms); }
  std::vector<double> values() const {
    std::vector<double> out;
    for (const std::vector<double>& rounds : rounds_) {
      if (!rounds.empty()) out.push_back(evaluation::median(rounds));
    }
    return out;
  }

 private:
  std::vector<std::vector<double>> rounds_;
};

// All times of one method: of the whole solve (CPU) and of its stages (wall) in their order.
struct MethodTimes {
  std::string name;
  std::unique_ptr<WindowSolver> solver;
  WindowTimes all;
  std::vector<std::pair<std::string, WindowTimes>> stages;
  std::size_t answered = 0;

  WindowTimes& stage(const std::string& stage_name, std::size_t windows) {
    for (auto& [known, times] : stages) {
      if (known == stage_name) return times;
    }
    stages.emplace_back(stage_name, WindowTimes(windows));
    return stages.back().second;
  }
};

bool isOfStepsOneAndTwo(const std::string& stage) {
  return stage == "vanishing_points" || stage == "gyro_bias" || stage == "integration" ||
         stage == "translation";
}

InitializerOptions optionsOf(const Command& command) {
  InitializerOptions options;
  options.window.keyframes = command.windows.keyframes;
  options.window.min_keyframes = command.windows.keyframes;
  return options;
}

std::vector<MethodTimes> timeAll(const Command& command, const Windows& windows) {
  std::vector<MethodTimes> methods;
  for (const std::string& name : split(command.methods)) {
    std::string error;
    auto solver = makeKnownMethod(name, optionsOf(command), {}, &error);
    if (solver == nullptr) {
      std::cerr << "slim_init_bench: " << error << "\n";
      std::exit(2);
    }
    methods.push_back({name, std::move(solver), WindowTimes(windows.size()), {}, 0});
  }
  // The methods take turns, so that all of them meet the machine in the same state. The first round
  // fills caches and does not count.
  for (int round = -1; round < command.rounds; ++round) {
    for (std::size_t w = 0; w < windows.size(); ++w) {
      for (MethodTimes& method : methods) {
        const double start = evaluation::threadCpuMs();
        const InitResult result = method.solver->solve(*windows[w]);
        const double ms = evaluation::threadCpuMs() - start;
        if (round < 0) continue;
        method.all.add(w, ms);
        method.answered += result.hasEstimate() ? 1 : 0;
        double steps = 0.0;
        for (const StageTime& stage : result.stages) {
          method.stage(stage.name, windows.size()).add(w, stage.ms);
          if (isOfStepsOneAndTwo(stage.name)) steps += stage.ms;
        }
        method.stage(kSteps, windows.size()).add(w, steps);
      }
    }
  }
  return methods;
}

Windows windowsOf(const Command& command) {
  BenchWindows what = command.windows;
  if (command.recorded.empty()) return cutWindows(benchSequence(what), what);
  Windows all;
  for (const std::string& folder : command.recorded) {
    what.recorded = folder;
    const Windows some = cutWindows(benchSequence(what), what);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

std::vector<double> stageValues(const MethodTimes& method, const std::string& stage) {
  for (const auto& [name, times] : method.stages) {
    if (name == stage) return times.values();
  }
  return {};
}

int runTimes(const Command& command) {
  const Windows windows = windowsOf(command);
  const std::vector<MethodTimes> methods = timeAll(command, windows);
  const auto reference =
      std::find_if(methods.begin(), methods.end(),
                   [](const MethodTimes& method) { return method.name == kReference; });
  const bool compares = reference != methods.end();
  std::printf("%zu windows of %d keyframes, %d rounds; ms, ratios of the medians to %s\n\n",
              windows.size(), command.windows.keyframes, command.rounds, kReference);
  std::printf("| method | what | median | p90 | p99 | p99 / median | ratio |\n");
  std::printf("|---|---|---:|---:|---:|---:|---:|\n");
  const auto row = [&](const std::string& method, const std::string& what,
                       const std::vector<double>& values, const std::vector<double>& to) {
    const double median = evaluation::median(values);
    const double p99 = evaluation::quantile(values, 0.99);
    std::printf("| `%s` | %s | %.3f | %.3f | %.3f | %.2f |", method.c_str(), what.c_str(), median,
                evaluation::quantile(values, 0.9), p99, p99 / median);
    if (to.empty()) {
      std::printf(" |\n");
    } else {
      std::printf(" %.2f |\n", median / evaluation::median(to));
    }
  };
  const std::vector<double> none;
  for (const MethodTimes& method : methods) {
    row(method.name, "solve", method.all.values(), compares ? reference->all.values() : none);
    row(method.name, kSteps, stageValues(method, kSteps),
        compares ? stageValues(*reference, kSteps) : none);
    for (const auto& [name, times] : method.stages) {
      if (name != kSteps) row(method.name, name, times.values(), none);
    }
  }
  std::printf("\n");
  for (const MethodTimes& method : methods) {
    std::printf("%s solved %zu of %zu\n", method.name.c_str(),
                method.answered / static_cast<std::size_t>(std::max(command.rounds, 1)),
                windows.size());
  }
  return 0;
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

// Solves every window once per method, for a tool that counts instructions. One solve before, so
// that tables made by the first are not counted.
int runCount(const Command& command) {
  const Windows windows = windowsOf(command);
  for (const std::string& name : split(command.methods)) {
    const auto solver = makeKnownMethod(name, optionsOf(command));
    if (solver == nullptr) return 2;
    if (!command.answers.empty()) {
      const std::string problem = writeAnswers(command.answers, *solver, windows);
      if (!problem.empty()) {
        std::cerr << "slim_init_bench: " << problem << "\n";
        return 1;
      }
    }
    solver->solve(*windows.front());
    std::printf("%s %zu windows %zu solved\n", name.c_str(), windows.size(),
                countedSolves(*solver, windows));
  }
  return 0;
}

}  // namespace

int runTimesCommand(const std::vector<std::string>& arguments) {
  Command command;
  command.name = arguments[0];
  BenchWindows& windows = command.windows;
  po::options_description table("slim_init_bench times|count, options");
  addSequenceOptions(&command.recorded, &windows, &table);
  auto add = table.add_options();
  add("methods", po::value(&command.methods)->default_value(command.methods), "comma separated");
  add("points", po::value(&windows.points)->default_value(windows.points), "per frame");
  add("lines", po::value(&windows.lines)->default_value(windows.lines), "per frame");
  add("outliers", po::value(&windows.outliers)->default_value(windows.outliers),
      "fraction of the point tracks");
  add("drift", po::value(&windows.drift)->default_value(windows.drift),
      "random walk of a point track, per image and axis [px]");
  add("keyframes", po::value(&windows.keyframes)->default_value(windows.keyframes), "per window");
  add("windows", po::value(&windows.limit)->default_value(windows.limit),
      "maximum number for each sequence");
  add("rounds", po::value(&command.rounds)->default_value(command.rounds),
      "every window is solved as often as this");
  add("answers", po::value(&command.answers), "count: file to which all estimates are appended");
  const std::vector<std::string> options(arguments.begin() + 1, arguments.end());
  if (const auto code = readOptions(table, options)) return *code;
  if (command.name == "times") return runTimes(command);
  return runCount(command);
}

}  // namespace slim_init::tools
