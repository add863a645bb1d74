// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Times of the solvers and their stages on simulated windows of 10 keyframes (Google Benchmark).
// Windows come from the built-in circle, seen by 30, 100 or 300 tracked points and 25 lines a
// frame. Each iteration solves the next of 40 windows, so that no single one decides.
// SLIM_INIT_BENCH_SEQUENCE=DIR adds the image front end on the recording in that ASL folder.
//
// `slim_init_bench times`, `growth` and `count` (each with --help) print tables of whole solves
// instead, also on recorded motion; `faults` and `soak` run a host on streams with faults
// (bench_commands.h).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bench_commands.h"
#include "bench_windows.h"
#include "methods.h"
#include "slim_init/evaluation/protocol.h"
#include "slim_init/keyframe_window.h"

namespace slim_init::tools {
namespace {

constexpr std::size_t kWindows = 40;

BenchWindows circle(int points) {
  BenchWindows what;
  what.points = points;
  what.limit = kWindows;
  return what;
}

const evaluation::Sequence& sequence(int points) {
  static std::map<int, evaluation::Sequence> cache;
  const auto found = cache.find(points);
  if (found != cache.end()) return found->second;
  return cache[points] = benchSequence(circle(points));
}

const std::vector<std::shared_ptr<const InitWindow>>& windows(int points) {
  static std::map<int, std::vector<std::shared_ptr<const InitWindow>>> cache;
  std::vector<std::shared_ptr<const InitWindow>>& out = cache[points];
  if (out.empty()) out = cutWindows(sequence(points), circle(points));
  return out;
}

void solve(benchmark::State& state, const std::string& method) {
  const auto& input = windows(static_cast<int>(state.range(0)));
  const auto solver = makeKnownMethod(method, InitializerOptions());
  std::size_t i = 0, answered = 0, solved = 0;
  double tracks = 0.0;
  for (auto _ : state) {
    const InitResult result = solver->solve(*input[i]);
    benchmark::DoNotOptimize(&result);
    answered += result.hasEstimate() ? 1 : 0;
    tracks += result.counts.point_tracks;
    ++solved;
    i = (i + 1) % input.size();
  }
  // A fast refusal is no solve.
  if (answered < solved) state.SkipWithError("a window was not solved");
  state.counters["tracks"] = tracks / static_cast<double>(std::max<std::size_t>(solved, 1));
}

// The median of what every solve took, and of every stage as the solver reports it: the mean of a
// shared machine is that of its interruptions. Also the slowest of a hundred, and the gyroscope
// bias and translations together (steps 1 and 2 of the paper). Every window is solved equally
// often.
void stages(benchmark::State& state, const std::string& method) {
  const auto& input = windows(100);
  const auto solver = makeKnownMethod(method, InitializerOptions());
  std::map<std::string, std::vector<double>> times;
  std::size_t i = 0;
  for (auto _ : state) {
    const InitResult result = solver->solve(*input[i]);
    double all = 0.0, steps = 0.0;
    for (const StageTime& stage : result.stages) {
      times[stage.name + "_ms"].push_back(stage.ms);
      all += stage.ms;
      if (stage.name == "vanishing_points" || stage.name == "gyro_bias" ||
          stage.name == "integration" || stage.name == "translation") {
        steps += stage.ms;
      }
    }
    times["all_ms"].push_back(all);
    times["steps_1_2_ms"].push_back(steps);
    i = (i + 1) % input.size();
  }
  const auto quantile = [](std::vector<double>& values, double share) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * (values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
  };
  for (auto& [name, values] : times) state.counters[name] = quantile(values, 0.5);
  if (!times.empty()) state.counters["all_p99_ms"] = quantile(times["all_ms"], 0.99);
}

// From ring buffer to window: what a host pays before the solve.
void cutWindow(benchmark::State& state) {
  const evaluation::Sequence& data = sequence(100);
  KeyframeWindow stream(data.calibration, evaluation::paperWindow());
  std::size_t next_imu = 0;
  for (std::size_t k = 0; k < 200 && k < data.frames.size(); ++k) {
    while (next_imu < data.imu.size() && data.imu[next_imu].t <= data.frames[k].t + 0.01) {
      stream.addImu(data.imu[next_imu++]);
    }
    stream.addFrame(data.frames[k]);
  }
  for (auto _ : state) {
    const WindowCut cut = stream.cut();
    benchmark::DoNotOptimize(&cut);
    if (cut.window == nullptr) state.SkipWithError("no window");
  }
}

}  // namespace
}  // namespace slim_init::tools

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const std::string command = arguments.empty() ? "" : arguments[0];
  if (command == "faults") {
    return slim_init::tools::runFaultsCommand({arguments.begin() + 1, arguments.end()});
  }
  if (command == "soak") {
    return slim_init::tools::runSoakCommand({arguments.begin() + 1, arguments.end()});
  }
  if (command == "times" || command == "growth" || command == "count") {
    return slim_init::tools::runTimesCommand(arguments);
  }
  for (const std::string& name : slim_init::tools::methodNames()) {
    benchmark::RegisterBenchmark(
        ("solve/" + name).c_str(),
        [name](benchmark::State& state) { slim_init::tools::solve(state, name); })
        ->Arg(30)
        ->Arg(100)
        ->Arg(300)
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("stages/" + name).c_str(), [name](benchmark::State& state) {
      slim_init::tools::stages(state, name);
    })->Unit(benchmark::kMillisecond);
  }
  benchmark::RegisterBenchmark("cut_window", slim_init::tools::cutWindow)
      ->Unit(benchmark::kMillisecond);
  if (!slim_init::tools::registerFrontEndBenchmarks(std::getenv("SLIM_INIT_BENCH_SEQUENCE"))) {
    return 1;
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
