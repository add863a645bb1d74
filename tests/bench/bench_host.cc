// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "bench_host.h"

#include <Eigen/Core>
#include <algorithm>
#include <limits>

namespace slim_init::tools {
namespace {

using vins_adapter::HostAdapter;

constexpr double kFirstTrouble = 0.4;    // [s] after the start
constexpr double kTrouble = 0.6;         // its length [s]
constexpr double kFrameInterval = 0.09;  // a host takes every second image of 20 Hz [s]
constexpr double kTransport = 0.03;      // from the exposure of an image to its tracks [s]
constexpr std::size_t kHostFrames = 11;  // in the host's window

template <typename Message>
void sortByArrival(std::vector<Delivered<Message>>* list) {
  std::stable_sort(list->begin(), list->end(),
                   [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
}

vins_adapter::HostOptions hostOptions() {
  vins_adapter::HostOptions options;
  options.reinit = true;
  options.max_wait_ms = -1.0;  // equal seeds, equal results
  return options;
}

}  // namespace

Streams streamsFrom(const evaluation::Sequence& sequence, double start, double seconds) {
  Streams streams;
  streams.calibration = sequence.calibration;
  // Both lists are ascending, and a day of starts looks for its place in them.
  const auto first_imu =
      std::lower_bound(sequence.imu.begin(), sequence.imu.end(), start,
                       [](const ImuSample& sample, double t) { return sample.t < t; });
  for (auto sample = first_imu; sample != sequence.imu.end() && sample->t < start + seconds;
       ++sample) {
    streams.imu.push_back({sample->t, sample->t, *sample});
  }
  const Calibration& truth = sequence.trueCalibration();
  const auto first_frame = std::lower_bound(
      sequence.frames.begin(), sequence.frames.end(), start,
      [&truth](const FrameObservation& frame, double t) { return truth.imuTime(frame.t) < t; });
  for (auto frame = first_frame; frame != sequence.frames.end(); ++frame) {
    const double t = truth.imuTime(frame->t);
    if (t >= start + seconds) break;
    if (!streams.frames.empty() && t < streams.frames.back().true_t + kFrameInterval) continue;
    streams.frames.push_back({t + kTransport, t, *frame});
  }
  return streams;
}

void applyFault(const StreamFault& fault, double start, double seconds, std::mt19937_64* random,
                Streams* streams) {
  const Trouble whole = {start, start + seconds};
  const Trouble passing = {start + kFirstTrouble, start + kFirstTrouble + kTrouble};
  fault.apply({fault.lasts ? whole : passing, *random, *streams});
  sortByArrival(&streams->imu);
  sortByArrival(&streams->frames);
}

BenchHost::BenchHost(const evaluation::Sequence& sequence, const Calibration& calibration)
    : sequence_(sequence), calibration_(calibration) {
  restart();
}

void BenchHost::restart() {
  adapter_ = HostAdapter::create(makeInitializer(calibration_, InitializerOptions()), hostOptions(),
                                 nullptr);
  window_.clear();
}

void BenchHost::feed(Streams streams, const std::function<bool(double arrival)>& seen) {
  auto imu = streams.imu.begin();
  for (const auto& frame : streams.frames) {
    if (streams.restart <= frame.arrival) {
      restart();
      streams.restart = std::numeric_limits<double>::infinity();
    }
    for (; imu != streams.imu.end() && imu->arrival <= frame.arrival; ++imu) {
      adapter_->addImu(imu->message.t, imu->message.accel, imu->message.gyro);
    }
    if (add(frame) && !seen(frame.arrival)) return;
  }
}

bool BenchHost::add(const Delivered<FrameObservation>& frame) {
  const AddStatus status = adapter_->addFrame(frame.message);
  if (!isAdded(status)) return false;
  if (status == AddStatus::kRestarted) window_.clear();
  window_[frame.message.t] = frame.true_t;
  if (window_.size() > kHostFrames) window_.erase(window_.begin());
  return true;
}

std::vector<double> BenchHost::stamps() const {
  std::vector<double> all;
  for (const auto& [stamp, true_t] : window_) all.push_back(stamp);
  return all;
}

bool BenchHost::seed() {
  answer_ = adapter_->seed(stamps());
  if (answer_.success()) started_ = answer_.window.states.back();
  return answer_.success();
}

bool BenchHost::recover() {
  const auto& [stamp, true_t] = *window_.begin();
  vins_adapter::HostState healthy =
      vins_adapter::toHostState(evaluation::truthAt(sequence_, true_t), 0.0);
  healthy.stamp = stamp;
  healthy.Bg = started_.Bg;
  healthy.Ba = started_.Ba;
  answer_ = adapter_->recover(stamps(), {healthy});
  return answer_.success();
}

double BenchHost::scaleError() const {
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

}  // namespace slim_init::tools
