// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "snapshot_solve.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "data/with_calibration.h"
#include "imu/carry_prior.h"
#include "imu/preintegration.h"
#include "join_frame.h"
#include "provisional.h"

namespace slim_init {
namespace {

// A solve this long after the one before has none before it to be compared with [s]: two images at
// 10 Hz, and a half.
constexpr double kSuccessive = 0.25;
// States of a history that are tried, the newest first.
constexpr int kMostTries = 3;

InitResult refuse(InitStatus status, const std::string& message) {
  InitResult result;
  result.status = status;
  result.message = message;
  return result;
}

// State of the body at time t, carried there from `state` by the IMU.
NavState propagateTo(const NavState& state, double t, const std::vector<ImuSample>& imu,
                     const Eigen::Vector3d& gravity_w, const ImuNoise& noise) {
  if (t <= state.t) return state;
  return propagate(state,
                   preintegrate(imu, state.t, t, state.gyro_bias, state.accel_bias, noise,
                                PreintegrationParts::kMean),
                   gravity_w);
}

// Longest time between neighbouring samples that touches [t_from, t_to]; zero for an empty
// interval.
double largestGap(const std::vector<ImuSample>& imu, double t_from, double t_to) {
  double largest = 0.0;
  for (std::size_t i = 1; i < imu.size(); ++i) {
    if (imu[i].t <= t_from || imu[i - 1].t >= t_to) continue;
    largest = std::max(largest, imu[i].t - imu[i - 1].t);
  }
  return largest;
}

}  // namespace

SolveMemory::ShortKey::ShortKey(const InitWindow& window, int known)
    : times(window.times()), td(window.calibration().td), knowledge(known) {
  for (int k = 0; k < window.size(); ++k) lines += window.linesOfKeyframe(k).size();
}

bool SolveMemory::ShortKey::operator==(const ShortKey& other) const {
  return times == other.times && td == other.td && lines == other.lines &&
         knowledge == other.knowledge;
}

SnapshotSolve::SnapshotSolve(const WindowSolver& solver,
                             const std::optional<WindowOptions>& short_window,
                             KeyframeWindow window, SensorKnowledge known, SolveMemory* memory)
    : solver_(solver),
      short_window_(short_window),
      window_(std::move(window)),
      known_(std::move(known)),
      memory_(*memory),
      imu_(window_.imu().begin(), window_.imu().end()) {}

InitResult SnapshotSolve::initialize() {
  const WindowCut cut = informed(window_.cut());
  InitResult result =
      cut.window == nullptr ? refuse(cut.status, cut.message) : answer(*cut.window);
  if (short_window_ && !result.success()) offerProvisional(&result);
  if (const std::string message = result.validate(); !message.empty()) {
    return refuse(InitStatus::kNumericalFailure, solver_.name() + " reported " + message);
  }
  return result;
}

InitResult SnapshotSolve::recover(const NavState& last_healthy) {
  const std::string problem = checkHealthy(last_healthy);
  if (!problem.empty()) return refuse(InitStatus::kInvalidInput, problem);
  InitResult result = initialize();
  if (!result.success() && !result.provisional()) return result;
  // Between the healthy state and the window the IMU alone carries the frame.
  if (const std::string gap = checkGap(last_healthy.t, result.states.front().t); !gap.empty()) {
    return refuse(InitStatus::kInvalidInput, gap);
  }
  join(last_healthy, &result);
  return result;
}

InitResult SnapshotSolve::recoverWithPrior(const std::vector<StatePrior>& healthy) {
  if (healthy.empty()) {
    return refuse(InitStatus::kInvalidInput, "there is no healthy state to recover from");
  }
  std::optional<InitResult> best;
  InitResult refusal;
  std::string reasons;
  int tries = 0;
  for (auto prior = healthy.rbegin(); prior != healthy.rend() && tries < kMostTries; ++prior) {
    InitResult result = answerWithPrior(*prior);
    if (result.status != InitStatus::kTooFewKeyframes) ++tries;
    if (!result.success()) {
      // Where all are too new, that of the oldest; else of those that were tried.
      if (tries <= 1) reasons.clear();
      reasons += (reasons.empty() ? "" : "; ") + result.message;
      refusal = std::move(result);
      continue;
    }
    if (result.prior_dropped.empty()) return result;
    if (!best || result.prior_dropped.size() < best->prior_dropped.size()) {
      best = std::move(result);
    }
  }
  if (best) return *std::move(best);
  refusal.message = reasons;
  return refusal;
}

// The window with what is known of the sensors.
WindowCut SnapshotSolve::informed(WindowCut cut) const {
  if (cut.window == nullptr || !known_.has_value) return cut;
  Calibration calibration = cut.window->calibration();
  if (known_.sensors.calibration) {
    calibration = withFound(calibration, *known_.sensors.calibration);
  }
  calibration.imu_biases = known_.sensors.biases;
  // A td that moves the keyframes away from the samples is none.
  if (const auto window = withCalibration(*cut.window, calibration)) cut.window = window;
  return cut;
}

// Judged by the answers before it.
InitResult SnapshotSolve::answer(const InitWindow& window) {
  InitResult result = solver_.solve(window);
  const double newest = window.times().back();
  if (result.success() && result.hasEstimate() &&
      !(std::abs(newest - memory_.last_solved) <= kSuccessive)) {
    answerEarlier(window.size(), result);
  }
  memory_.answers.judge(&result);
  memory_.last_solved = newest;
  return result;
}

// A host that solves at every image has earlier answers to agree with. One that solves now and then
// has none: the window is solved as it was before its newest keyframes.
void SnapshotSolve::answerEarlier(int keyframes, const InitResult& result) {
  memory_.answers.reset();
  const std::vector<NavState>& states = result.states;
  if (states.back().t - states.front().t >=
      AnswerSequence::kFullShare * window_.options().fullSpan())
    return;
  // Keyframes that td has moved past the IMU are in neither answer.
  const int lost = std::max(0, keyframes - static_cast<int>(states.size()));
  for (int earlier = AnswerSequence::kEarlierAnswers; earlier > 0; --earlier) {
    const WindowCut before = informed(window_.cut(lost + earlier));
    if (before.window == nullptr) continue;
    InitResult answer = solver_.solve(*before.window);
    memory_.answers.judge(&answer);
  }
}

// What a host that takes a prior can start with. Where there is nothing, `result` keeps its own
// reason.
void SnapshotSolve::offerProvisional(InitResult* result) {
  const WindowCut cut = informed(window_.cut(*short_window_, 0));
  if (cut.window == nullptr) return;
  const InitResult now = shortAnswer(*cut.window);
  if (!now.provisional()) return;
  // As it was before the newest third of the data.
  const int third = std::max(1, cut.window->size() / 3);
  const WindowCut before = informed(window_.cut(*short_window_, third));
  if (before.window == nullptr) return;
  if (agrees(shortAnswer(*before.window), now)) *result = now;
}

// While the window grows, a host that solves at every image has solved the earlier one already.
InitResult SnapshotSolve::shortAnswer(const InitWindow& window) {
  std::deque<SolveMemory::ShortAnswer>& known = memory_.short_answers;
  const SolveMemory::ShortKey key(window, known_.version);
  for (const SolveMemory::ShortAnswer& one : known) {
    if (one.key == key) return one.answer;
  }
  if (static_cast<int>(known.size()) >= short_window_->keyframes) known.pop_front();
  known.push_back({key, solver_.solveProvisional(window)});
  return known.back().answer;
}

// From the frames after a known state.
InitResult SnapshotSolve::answerWithPrior(const StatePrior& prior) {
  std::string problem = prior.validate();
  if (problem.empty()) problem = checkHealthy(prior.state);
  if (!problem.empty()) return refuse(InitStatus::kInvalidInput, problem);
  const WindowCut cut = window_.cutSince(prior.state.t);
  if (cut.window == nullptr) return refuse(cut.status, cut.message);
  const double first = cut.window->times().front();
  if (const std::string gap = checkGap(prior.state.t, first); !gap.empty()) {
    return refuse(InitStatus::kInvalidInput, gap);
  }
  const Calibration& calibration = window_.calibration();
  InitResult result = solver_.solveWithPrior(
      *cut.window,
      carryPrior(prior, first, imu_, calibration.gravity_magnitude, calibration.imu_noise));
  if (const std::string message = result.validate(); !message.empty()) {
    return refuse(InitStatus::kNumericalFailure, solver_.name() + " reported " + message);
  }
  return result;
}

// Where the IMU data cannot carry a state over this time, why; or "".
std::string SnapshotSolve::checkGap(double from, double to) const {
  const double gap = largestGap(imu_, from, to);
  if (!(gap > window_.options().max_imu_gap_s)) return "";
  std::ostringstream message;
  message << "IMU data have a gap of " << gap
          << " s between the last healthy state and the window, must be at most "
          << window_.options().max_imu_gap_s << " s";
  return message.str();
}

// Why nothing can be joined to this state, or "".
std::string SnapshotSolve::checkHealthy(const NavState& last_healthy) const {
  StatePrior state;
  state.state = last_healthy;
  if (const std::string problem = state.validate(); !problem.empty()) return problem;
  if (!imu_.empty() && last_healthy.t >= imu_.front().t && last_healthy.t <= imu_.back().t) {
    return "";
  }
  std::ostringstream message;
  message << "the last healthy state at " << std::fixed << last_healthy.t
          << " s lies outside the buffered IMU data";
  if (!imu_.empty()) message << " [" << imu_.front().t << ", " << imu_.back().t << "] s";
  return message.str();
}

// Moves the new solution into the old odometry frame: both describe the body at one instant, the
// first at which both exist.
void SnapshotSolve::join(const NavState& last_healthy, InitResult* result) const {
  const ImuNoise& noise = window_.calibration().imu_noise;
  NavState old_state = last_healthy;
  // The host's biases may be what failed; the new ones carry the old state on.
  NavState new_state = result->states.front();
  for (const NavState& state : result->states) {
    if (state.t <= last_healthy.t) new_state = state;
  }
  old_state.gyro_bias = new_state.gyro_bias;
  old_state.accel_bias = new_state.accel_bias;
  old_state = propagateTo(old_state, new_state.t, imu_, result->gravity_w, noise);
  new_state = propagateTo(new_state, old_state.t, imu_, result->gravity_w, noise);
  joinFrame(old_state, new_state, result);
}

}  // namespace slim_init
