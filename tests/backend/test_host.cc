// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "backend/test_host.h"

#include <utility>

#include "slim_init/initializer.h"
#include "slim_init/vins_adapter/host_convention.h"

namespace slim_init::backend {
namespace {

using vins_adapter::HostAdapter;
using vins_adapter::HostResult;
using vins_adapter::HostState;
using vins_adapter::toHostState;

// Healthy states kept, as in HostGlue [s].
constexpr double kHealthyKept = 30.0;

// States of the last moments before a failure was noticed are not trusted [s].
constexpr double kSuspect = 0.5;

std::unique_ptr<HostAdapter> makeAdapter(const Calibration& calibration, double max_wait_ms) {
  vins_adapter::HostOptions options;
  options.reinit = options.watchdog = true;
  options.max_wait_ms = max_wait_ms;
  return HostAdapter::create(makeInitializer(calibration, InitializerOptions()), options, nullptr);
}

}  // namespace

TestHost::TestHost(const Calibration& calibration, double max_wait_ms)
    : adapter_(makeAdapter(calibration, max_wait_ms)),
      estimator_(SlidingWindowEstimator::make(calibration)) {}

void TestHost::addImu(const ImuSample& sample) {
  adapter_->addImu(sample.t, sample.accel, sample.gyro);
  estimator_->addImu(sample);
}

HostStep TestHost::addFrame(const FrameObservation& frame) {
  HostStep step;
  adapter_->addFrame(frame);
  const bool was_tracking = estimator_->seeded();
  const NavState before = estimator_->newest();
  const FrameReport report = estimator_->addFrame(frame);

  if (!was_tracking) {
    if (static_cast<int>(estimator_->stamps().size()) >=
        SlidingWindowEstimator::kWindowFrames - 1) {
      seed(&step);
    }
  } else {
    step.message = report.problem;
    if (estimator_->seeded() && report.ok()) {
      step.message = detectFailure(before, estimator_->newest(), report);
    }
    step.failed = !estimator_->seeded() || (report.ok() && !step.message.empty());
    if (!step.failed) watch(&step);
    if (step.failed) recover(&step);
  }

  step.tracking = estimator_->seeded();
  if (step.tracking) {
    step.state = estimator_->newest();
    if (!suspect_) remember();
  }
  return step;
}

void TestHost::seed(HostStep* step) {
  const std::vector<double> stamps = estimator_->stamps();
  const bool joins = lost_ && adapter_->propagate(*lost_, stamps.front()).ok;
  step->seeded =
      fillWindow(joins ? adapter_->recover(stamps, {*lost_}) : adapter_->seed(stamps), step);
}

void TestHost::watch(HostStep* step) {
  const Calibration calibration = adapter_->info().calibration;
  std::vector<HostState> window;
  for (const NavState& state : estimator_->states()) {
    window.push_back(toHostState(state, calibration.td));
  }
  const vins_adapter::HostHealth health =
      adapter_->watch(window, calibration.R_b_c, calibration.t_b_c);
  suspect_ = health.suspect || !health.healthy;
  if (health.healthy) return;
  step->failed = true;
  step->message = "watchdog: " + health.reason;
}

void TestHost::recover(HostStep* step) {
  const std::vector<HostState> from = healthyStates();
  HostResult answer = adapter_->recover(estimator_->stamps(), from);
  if (answer.pending) answer = adapter_->bridge(estimator_->stamps(), from);
  step->recovered = fillWindow(answer, step);
  if (step->recovered) return;
  lost_ = from.back();
  healthy_.clear();
  step->reset = !isWait(answer.result.status);
  if (step->reset) {
    estimator_->reset();
  } else {
    estimator_->unseed();
  }
}

bool TestHost::fillWindow(const HostResult& answer, HostStep* step) {
  step->message += (step->message.empty() ? "" : "; ") + answer.message;
  if (!answer.success()) return false;
  std::vector<NavState> states;
  for (const HostState& state : answer.window.states) {
    states.push_back(vins_adapter::fromHostState(state, adapter_->info().calibration.td));
  }
  leaveOutDamage();
  const FrameReport report = estimator_->seed(states);
  suspect_ = suspect_ && !report.ok();
  if (!report.ok()) step->message += "; " + report.problem;
  return report.ok();
}

// What threw it off is still in its window, as in VINS-Mono's.
void TestHost::leaveOutDamage() {
  const std::vector<double> stamps = estimator_->stamps();
  const std::vector<vins_adapter::HostImuInterval> intervals = adapter_->imuIntervals(stamps);
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    if (!intervals[i].damaged) continue;
    std::vector<ImuSample> samples(intervals[i].dt.size());
    double t = adapter_->info().calibration.imuTime(stamps[i]);
    for (std::size_t k = 0; k < samples.size(); ++k) {
      samples[k].t = t += intervals[i].dt[k];
      samples[k].accel = intervals[i].accel[k];
      samples[k].gyro = intervals[i].gyro[k];
    }
    estimator_->replaceImu(samples);
  }
}

// Those that are old enough, or the oldest there is.
std::vector<HostState> TestHost::healthyStates() const {
  const double newest = estimator_->stamps().back();
  std::vector<HostState> states = {healthy_.front()};
  for (const HostState& candidate : healthy_) {
    if (candidate.stamp > healthy_.front().stamp && newest - candidate.stamp >= kSuspect) {
      states.push_back(candidate);
    }
  }
  return states;
}

// The newest state, and of the first window those before it.
void TestHost::remember() {
  lost_.reset();
  const std::vector<NavState> states = estimator_->states();
  const std::size_t first = healthy_.empty() ? 0 : states.size() - 1;
  for (std::size_t i = first; i < states.size(); ++i) {
    healthy_.push_back(toHostState(states[i], adapter_->info().calibration.td));
  }
  while (healthy_.front().stamp < healthy_.back().stamp - kHealthyKept) {
    healthy_.erase(healthy_.begin());
  }
}

}  // namespace slim_init::backend
