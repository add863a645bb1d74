// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "bench_faults.h"

#include <Eigen/Core>
#include <algorithm>
#include <boost/program_options.hpp>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <map>
#include <memory>

#include "bench_options.h"
#include "bench_windows.h"
#include "slim_init/evaluation/sequence.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/vins_adapter/host_adapter.h"
#include "stream_faults.h"

namespace slim_init::tools {
namespace {

namespace po = boost::program_options;
using vins_adapter::HostAdapter;

constexpr double kFirstTrouble = 0.4;          // [s] after the start
constexpr double kTrouble = 0.6;               // its length [s]
constexpr double kGiveUp = 8.0;                // [s]
constexpr double kFrameInterval = 0.09;        // a host takes every second image of 20 Hz [s]
constexpr double kTransport = 0.03;            // from the exposure of an image to its tracks [s]
constexpr std::size_t kHostFrames = 11;        // in the host's window
constexpr double kRight = 0.1, kWrong = 0.25;  // relative error of the scale

// What the starts under one fault came to.
struct Tally {
  int starts = 0, accepted = 0, right = 0, wrong = 0;
  double worst = 0.0;
  std::vector<double> seconds;  // from the start to the answer
  std::map<std::string, int> refusals;
};

Streams streamsFrom(const evaluation::Sequence& sequence, double start) {
  Streams streams;
  streams.calibration = sequence.calibration;
  for (const ImuSample& sample : sequence.imu) {
    if (sample.t >= start && sample.t < start + kGiveUp) {
      streams.imu.push_back({sample.t, sample.t, sample});
    }
  }
  for (const FrameObservation& frame : sequence.frames) {
    const double t = sequence.trueCalibration().imuTime(frame.t);
    if (t < start || t >= start + kGiveUp) continue;
    if (!streams.frames.empty() && t < streams.frames.back().true_t + kFrameInterval) continue;
    streams.frames.push_back({t + kTransport, t, frame});
  }
  return streams;
}

template <typename Message>
void sortByArrival(std::vector<Delivered<Message>>* list) {
  std::stable_sort(list->begin(), list->end(),
                   [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
}

// A host at its start: it keeps the newest frames and asks at each of them.
class Host {
 public:
  Host(const evaluation::Sequence& sequence, const Streams& streams)
      : sequence_(sequence),
        adapter_(HostAdapter::create(
            makeInitializer(streams.calibration, HostAdapter::hostDefaults()), {}, nullptr)) {}

  bool isMade() const { return adapter_ != nullptr; }
  void restart() {
    adapter_->reset();
    window_.clear();
  }
  void add(const ImuSample& sample) { adapter_->addImu(sample.t, sample.accel, sample.gyro); }

  /// True where that was the frame of an answer.
  bool add(const Delivered<FrameObservation>& frame) {
    const AddStatus status = adapter_->addFrame(frame.message);
    if (!isAdded(status)) return false;
    if (status == AddStatus::kRestarted) window_.clear();
    window_[frame.message.t] = frame.true_t;
    if (window_.size() > kHostFrames) window_.erase(window_.begin());
    std::vector<double> stamps;
    for (const auto& [stamp, true_t] : window_) stamps.push_back(stamp);
    answer_ = adapter_->seed(stamps);
    return answer_.success();
  }

  const std::string refusal() const { return toString(answer_.verdict.status); }

  /// Of the answer: spread of its positions over that of the true ones, minus one; NaN without
  /// truth.
  double scaleError() const {
    const auto n = static_cast<Eigen::Index>(window_.size());
    Eigen::Matrix3Xd estimate(3, n), truth(3, n);
    Eigen::Index k = 0;
    for (const auto& [stamp, true_t] : window_) {
      estimate.col(k) = answer_.window.states[static_cast<std::size_t>(k)].P;
      truth.col(k++) = evaluation::truthAt(sequence_, true_t).p_w_b;
    }
    const auto spread = [](const Eigen::Matrix3Xd& p) {
      return (p.colwise() - p.rowwise().mean()).norm();
    };
    return spread(estimate) / spread(truth) - 1.0;
  }

 private:
  const evaluation::Sequence& sequence_;
  std::unique_ptr<HostAdapter> adapter_;
  std::map<double, double> window_;  // stamp and true time
  vins_adapter::HostAnswer answer_;
};

void start(const evaluation::Sequence& sequence, double at, const StreamFault& fault,
           std::mt19937_64* random, Tally* tally) {
  Streams streams = streamsFrom(sequence, at);
  if (streams.imu.empty() || streams.frames.empty()) return;
  const Trouble whole = {at, at + kGiveUp};
  const Trouble passing = {at + kFirstTrouble, at + kFirstTrouble + kTrouble};
  fault.apply(fault.lasts ? whole : passing, random, &streams);
  sortByArrival(&streams.imu);
  sortByArrival(&streams.frames);
  Host host(sequence, streams);
  if (!host.isMade()) return;
  ++tally->starts;
  std::size_t next = 0;
  for (const auto& frame : streams.frames) {
    if (streams.restart <= frame.arrival) {
      host.restart();
      streams.restart = std::numeric_limits<double>::infinity();
    }
    while (next < streams.imu.size() && streams.imu[next].arrival <= frame.arrival) {
      host.add(streams.imu[next++].message);
    }
    if (!host.add(frame)) continue;
    const double error = std::abs(host.scaleError());
    ++tally->accepted;
    tally->right += error < kRight ? 1 : 0;
    tally->wrong += error > kWrong ? 1 : 0;
    tally->worst = std::max(tally->worst, error);
    tally->seconds.push_back(frame.arrival - at);
    return;
  }
  ++tally->refusals[host.refusal()];
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
  what.outliers = 0.03;
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
      100.0 * kRight, 100.0 * kWrong);
  for (std::size_t f = 0; f < faults.size(); ++f) {
    const Tally& tally = tallies[f];
    if (tally.starts == 0) continue;
    std::printf("| %s | %s | %d | %d | %d | %d | %.3f | %.2f | %.2f | %s |\n", faults[f].name,
                faults[f].what, tally.starts, tally.accepted, tally.right, tally.wrong, tally.worst,
                evaluation::median(tally.seconds), evaluation::quantile(tally.seconds, 0.9),
                refusalsOf(tally).c_str());
  }
  return 0;
}

}  // namespace slim_init::tools
