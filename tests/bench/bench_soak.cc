// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <utility>

#include "bench_commands.h"
#include "bench_host.h"
#include "bench_windows.h"
#include "exit_code.h"
#include "slim_init/evaluation/cpu_time.h"
#include "slim_init/evaluation/statistics.h"

namespace slim_init::tools {
namespace {

namespace po = boost::program_options;

constexpr double kHealthy = 1.5;    // from an answer to the failure of the host [s]
constexpr double kGiveUp = 8.0;     // a host that is not answered asks no longer than this [s]
constexpr double kRestarts = 0.25;  // share of the starts at which the host forgets its data
// Both streams stop before the next start [s], which is another place of the recording: longer than
// any window, so that none has data of two places.
constexpr double kPause = 4.0;
// Every start has tracks of its own; faults renumber tracks by 1000000.
constexpr FeatureId kTracksOfAStart = 10000000;
constexpr int kQuarters = 4;

struct SoakOptions {
  double hours = 24.0;          // simulated
  double every = 60.0;          // from one start of the host to the next [s]
  double ask = 0.5;             // from one question to the next [s]
  double memory_growth = 4.0;   // [MiB]
  double time_growth = 1.5;     // ratio of the times
  double answer_growth = 0.02;  // share of the answers
};

// A recording and the host that flies it.
struct Flight {
  evaluation::Sequence sequence;
  std::unique_ptr<BenchHost> host;
};

// A quarter of the day, which is a line of the table.
struct Quarter {
  int starts = 0, questions = 0, answers = 0, wrong = 0, failures = 0, recovered = 0;
  std::int64_t samples = 0, frames = 0;
  std::vector<double> ms;
  double mean_ms = kNotComputed, median_ms = kNotComputed, p99_ms = kNotComputed,
         memory = kNotComputed;
};

// Resident memory of this process [MiB].
double residentMemory() {
  std::ifstream file("/proc/self/statm");
  double size = 0.0, resident = kNotComputed;
  file >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1048576.0;
}

// From the time of the recording to that of the day, with new tracks.
void move(double seconds, FeatureId tracks, Streams* streams) {
  for (auto& imu : streams->imu) {
    imu.arrival += seconds;
    imu.message.t += seconds;
  }
  for (auto& frame : streams->frames) {
    frame.arrival += seconds;
    frame.message.t += seconds;
    for (PointObservation& point : frame.message.points) point.id += tracks;
    for (LineObservation& line : frame.message.lines) line.id += tracks;
  }
  streams->restart += seconds;
}

// The host starts, asks until it is answered, fails a while later, asks to recover until that is
// answered, and flies on.
void fly(Streams streams, double ask, BenchHost* host, Quarter* quarter) {
  ++quarter->starts;
  host->setTd(streams.calibration.td);
  enum class Flying { kStarts, kFlies, kFailed, kRecovered } now = Flying::kStarts;
  double since = streams.frames.front().arrival;  // when it began to [s]
  double asked = -std::numeric_limits<double>::infinity();
  quarter->samples += static_cast<std::int64_t>(streams.imu.size());
  quarter->frames += static_cast<std::int64_t>(streams.frames.size());
  host->feed(std::move(streams), [&](double arrival) {
    if (now == Flying::kFlies && arrival >= since + kHealthy) {
      now = Flying::kFailed;
      since = arrival;
      ++quarter->failures;
    }
    const bool asks = now == Flying::kStarts || now == Flying::kFailed;
    if (!asks || arrival > since + kGiveUp || arrival < asked + ask) return true;
    asked = arrival;
    const double begin = evaluation::threadCpuMs();
    const bool answered = now == Flying::kFailed ? host->recover() : host->seed();
    quarter->ms.push_back(evaluation::threadCpuMs() - begin);
    ++quarter->questions;
    if (!answered) return true;
    if (now == Flying::kFailed) {
      now = Flying::kRecovered;
      ++quarter->recovered;
    } else {
      now = Flying::kFlies;
      since = arrival;
      ++quarter->answers;
      quarter->wrong += std::abs(host->scaleError()) > kWrongScale ? 1 : 0;
    }
    return true;
  });
}

void printRow(double hour, const Quarter& quarter) {
  std::printf("| %.2f | %d | %lld | %lld | %d | %d | %d | %d | %d | %.2f | %.2f | %.2f | %.1f |\n",
              hour, quarter.starts, static_cast<long long>(quarter.samples),
              static_cast<long long>(quarter.frames), quarter.questions, quarter.answers,
              quarter.wrong, quarter.failures, quarter.recovered, quarter.mean_ms,
              quarter.median_ms, quarter.p99_ms, quarter.memory);
  std::fflush(stdout);
}

// Prints what was measured and its bound; false where it is beyond.
bool holds(const char* what, double measured, double bound, const char* unit) {
  const bool ok = measured <= bound;
  std::printf("%s: %.3f%s (limit %.3f%s)%s\n", what, measured, unit, bound, unit,
              ok ? "" : ": TOO MUCH");
  return ok;
}

// Both quarters have had the same faults in the same places.
bool isWithoutDrift(const Quarter& first, const Quarter& last, const SoakOptions& options) {
  std::printf("\nlast quarter against the first, which had the same faults at the same places:\n");
  const auto apart = [](int a, int b) { return std::abs(a - b) / std::max(1.0, 1.0 * a); };
  // All are printed, whatever becomes of the first.
  int beyond = 0;
  beyond += !holds("resident memory", last.memory - first.memory, options.memory_growth, " MiB");
  beyond += !holds("mean of a solve, ratio", last.mean_ms / first.mean_ms, options.time_growth, "");
  beyond +=
      !holds("median of a solve, ratio", last.median_ms / first.median_ms, options.time_growth, "");
  beyond += !holds("p99 of a solve, ratio", last.p99_ms / first.p99_ms, options.time_growth, "");
  beyond += !holds("estimates, difference", apart(first.answers, last.answers),
                   options.answer_growth, "");
  beyond += !holds("recoveries, difference", apart(first.recovered, last.recovered),
                   options.answer_growth, "");
  return beyond == 0;
}

std::vector<Flight> flightsOf(BenchWindows what, std::vector<std::string> recorded) {
  if (recorded.empty()) recorded.push_back("");
  std::vector<Flight> flights(recorded.size());
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    what.recorded = recorded[i];
    flights[i].sequence = benchSequence(what);
  }
  // The hosts keep pointers to the sequences, which stay where they are from here on.
  for (Flight& flight : flights) {
    flight.host = std::make_unique<BenchHost>(flight.sequence, flight.sequence.calibration);
  }
  return flights;
}

int soak(std::vector<Flight> flights, unsigned seed, const SoakOptions& options) {
  const int starts =
      std::max(1, static_cast<int>(options.hours * 3600.0 / options.every / kQuarters));
  std::printf(
      "| hour | starts | samples | images | solves | estimates | beyond %.0f %% | failures | "
      "recoveries | mean ms | median ms | p99 ms | MiB "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      100.0 * kWrongScale);
  const double seconds = options.every - kPause;
  std::vector<Quarter> quarters(kQuarters);
  std::vector<double> ms;
  int done = 0;
  for (Quarter& quarter : quarters) {
    // Every quarter of the day is the same, so that all that differs between them is their age.
    std::mt19937_64 random(seed);
    for (Flight& flight : flights) flight.host->restart();
    quarter.ms.swap(ms);
    quarter.ms.clear();
    for (int k = 0; k < starts; ++k, ++done) {
      Flight& flight = flights[random() % flights.size()];
      const StreamFault& fault = streamFaults()[random() % streamFaults().size()];
      const double first = flight.sequence.frames.front().t + 0.5;
      const double last = flight.sequence.frames.back().t - seconds;
      const double at = std::uniform_real_distribution<double>(first, last)(random);
      const bool restarts = std::uniform_real_distribution<double>()(random) < kRestarts;
      Streams streams = streamsFrom(flight.sequence, at, seconds);
      if (streams.imu.empty() || streams.frames.empty()) continue;
      applyFault(fault, at, seconds, &random, &streams);
      if (streams.imu.empty() || streams.frames.empty()) continue;
      move(done * options.every - at, done * kTracksOfAStart, &streams);
      if (restarts) flight.host->restart();
      fly(std::move(streams), options.ask, flight.host.get(), &quarter);
    }
    const double sum = std::accumulate(quarter.ms.begin(), quarter.ms.end(), 0.0);
    quarter.mean_ms = sum / static_cast<double>(quarter.ms.size());
    quarter.median_ms = evaluation::median(quarter.ms);
    quarter.p99_ms = evaluation::quantile(quarter.ms, 0.99);
    quarter.ms.swap(ms);
    quarter.memory = residentMemory();
    printRow(done * options.every / 3600.0, quarter);
  }
  return isWithoutDrift(quarters.front(), quarters.back(), options) ? 0 : 1;
}

}  // namespace

int runSoakCommand(const std::vector<std::string>& arguments) {
  BenchWindows what;
  what.duration_s = 120.0;
  what.drift = 0.04;
  std::vector<std::string> recorded;
  SoakOptions options;
  po::options_description table("slim_init_bench soak, options");
  addSequenceOptions(&recorded, &what, &table);
  auto add = table.add_options();
  const auto number = [](double* value) { return po::value(value)->default_value(*value); };
  add("hours", number(&options.hours), "simulated");
  add("every", number(&options.every), "from one start of the host to the next [s]");
  add("ask", number(&options.ask), "time between two solves [s]");
  add("memory-growth", number(&options.memory_growth),
      "maximum growth from the first quarter to the last [MiB]");
  add("time-growth", number(&options.time_growth), "maximum ratio of the solve times");
  add("answer-growth", number(&options.answer_growth),
      "maximum difference of the estimates (fraction)");
  if (const auto code = readOptions(table, arguments)) return *code;
  if (!(options.hours > 0.0 && options.hours <= 1000.0) || !(options.ask > 0.0)) {
    std::cerr << "slim_init_bench: --hours is " << options.hours
              << ", must be in (0, 1000]; --ask is " << options.ask << ", must be positive\n";
    return kExitBadInput;
  }
  std::vector<Flight> flights = flightsOf(what, recorded);
  for (const Flight& flight : flights) {
    const auto& frames = flight.sequence.frames;
    const double longest = frames.back().t - frames.front().t - 1.0 + kPause;
    if (options.every >= 2.0 * kPause && options.every <= longest) continue;
    std::cerr << "slim_init_bench: --every is " << options.every << " s, must be from "
              << 2.0 * kPause << " to " << longest << " s with " << flight.sequence.name << "\n";
    return kExitBadInput;
  }
  return soak(std::move(flights), what.seed, options);
}

}  // namespace slim_init::tools
