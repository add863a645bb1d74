// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <boost/program_options.hpp>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <utility>

#include "bench_commands.h"
#include "bench_host.h"
#include "bench_windows.h"
#include "slim_init/evaluation/sequence.h"
#include "slim_init/evaluation/statistics.h"
#include "stream_faults.h"

namespace slim_init::tools {
namespace {

namespace po = boost::program_options;

constexpr double kGiveUp = 8.0;  // a host that is not answered ends here [s]

// What the starts under one fault came to.
struct Tally {
  int starts = 0, accepted = 0, right = 0, wrong = 0;
  double worst = 0.0;
  std::vector<double> seconds;  // from the start to the answer
  std::map<std::string, int> refusals;
};

void start(const evaluation::Sequence& sequence, double at, const StreamFault& fault,
           std::mt19937_64* random, Tally* tally) {
  Streams streams = streamsFrom(sequence, at, kGiveUp);
  if (streams.imu.empty() || streams.frames.empty()) return;
  applyFault(fault, at, kGiveUp, random, &streams);
  BenchHost host(sequence, streams.calibration);
  if (!host.isMade()) return;
  ++tally->starts;
  bool answered = false;
  host.feed(std::move(streams), [&](double arrival) {
    answered = host.seed();
    if (answered) tally->seconds.push_back(arrival - at);
    return !answered;
  });
  if (!answered) {
    ++tally->refusals[toString(host.answer().result.status)];
    return;
  }
  const double error = std::abs(host.scaleError());
  ++tally->accepted;
  tally->right += error < kRightScale ? 1 : 0;
  tally->wrong += error > kWrongScale ? 1 : 0;
  tally->worst = std::max(tally->worst, error);
}

std::string refusalsOf(const Tally& tally) {
  std::string text;
  for (const auto& [status, count] : tally.refusals) {
    text += (text.empty() ? "" : ", ") + status + " " + std::to_string(count);
  }
  return text;
}

}  // namespace

int runFaultsCommand(const std::vector<std::string>& arguments) {
  BenchWindows what;
  what.drift = 0.04;
  std::vector<std::string> recorded;
  std::string only;
  int places = 10;
  po::options_description table("slim_init_bench faults, options");
  addSequenceOptions(&recorded, &what, &table);
  auto add = table.add_options();
  add("places", po::value(&places)->default_value(places), "starts of a sequence, spread over it");
  add("only", po::value(&only), "one fault, by name");
  if (const auto code = readOptions(table, arguments)) return *code;
  const auto& faults = streamFaults();
  if (places < 1 ||
      (!only.empty() &&
       std::none_of(faults.begin(), faults.end(), [&](const auto& f) { return only == f.name; }))) {
    std::cerr << "slim_init_bench: --places is " << places << ", at least 1; --only \"" << only
              << "\" must be a fault of the table\n";
    return 2;
  }
  if (recorded.empty()) recorded.push_back("");
  std::vector<Tally> tallies(faults.size());
  for (const std::string& folder : recorded) {
    what.recorded = folder;
    const evaluation::Sequence sequence = benchSequence(what);
    const double first = sequence.frames.front().t + 0.5;
    const double last = sequence.frames.back().t - kGiveUp;
    for (std::size_t f = 0; f < faults.size(); ++f) {
      if (!only.empty() && only != faults[f].name) continue;
      std::mt19937_64 random(what.seed);
      for (int k = 0; k < places; ++k) {
        start(sequence, first + (last - first) * k / places, faults[f], &random, &tallies[f]);
      }
    }
  }
  std::printf(
      "| fault | what | starts | accepted | within %.0f %% | beyond %.0f %% | largest | "
      "median s | p90 s | last refusals |\n|---|---|---|---|---|---|---|---|---|---|\n",
      100.0 * kRightScale, 100.0 * kWrongScale);
  for (std::size_t f = 0; f < faults.size(); ++f) {
    const Tally& tally = tallies[f];
    if (tally.starts == 0) continue;
    std::printf("| %s | %s | %d | %d | %d | %d ", faults[f].name, faults[f].what, tally.starts,
                tally.accepted, tally.right, tally.wrong);
    if (tally.accepted > 0) {
      std::printf("| %.3f | %.2f | %.2f ", tally.worst, evaluation::median(tally.seconds),
                  evaluation::quantile(tally.seconds, 0.9));
    } else {
      std::printf("| - | - | - ");
    }
    std::printf("| %s |\n", refusalsOf(tally).c_str());
  }
  return 0;
}

}  // namespace slim_init::tools
