// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "session/snapshot_solve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "data/derived_window.h"
#include "imu/preintegration.h"
#include "pipeline/solver_support.h"
#include "slim_init/state_at.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

// A solve this long after the one before has none before it to be compared with [s]: two images at
// 10 Hz, and a half.
constexpr double kSuccessive = 0.25;
// What a growing window has to agree with.
constexpr char kEarlier[] = "the window as it was before its newest keyframes";
// The prior of a rest is that of its state so long before its end [s]: what moves slower than the
// noise may have begun to move.
constexpr double kBeforeMotion = 0.15;
// Images need not fall on both ends of a span.
constexpr double kLeastOfSpan = 0.85;
// In a recovery the window alone has this share of the work; the rest is for a solve with a known
// state, which needs less data.
constexpr double kShareOfWindowAlone = 0.6;

InitResult refuse(InitStatus status, const std::string& message) {
  InitResult result;
  result.status = status;
  result.message = message;
  return result;
}

// Keyframes at every image, up to so many.
WindowOptions everyImage(int keyframes) {
  WindowOptions selection;
  selection.keyframes = keyframes;
  selection.min_keyframes = kMinKeyframes;
  selection.min_interval_s = selection.max_span_s = 0.0;
  return selection;
}

// The last state not after `t` [s], or else the first; there is one.
std::size_t lastUntil(double t, const std::vector<NavState>& states) {
  const auto after = std::find_if(states.begin() + 1, states.end(),
                                  [t](const NavState& state) { return state.t > t; });
  return after - states.begin() - 1;
}

// Whether its covariance says how far the estimate may be off: it was accepted, or refused only
// because the motion leaves its scale or attitude uncertain.
bool hasCovarianceOfItsErrors(const InitResult& result) {
  if (!result.hasEstimate() || result.covariance.size() == 0) return false;
  return std::all_of(result.gates.begin(), result.gates.end(), [](const GateValue& gate) {
    return gate.passed || !gate.enforced || gate.name == GateName::kScaleSigma ||
           gate.name == GateName::kTiltSigma || gate.name == GateName::kExcitation;
  });
}

}  // namespace

SnapshotSolve::SnapshotSolve(const WindowSolver& solver,
                             const std::optional<WindowOptions>& short_window,
                             const InitializerOptions& options, KeyframeWindow window,
                             const Priors& priors, SolveMemory* memory)
    : solver_(solver),
      short_window_(short_window),
      options_(options),
      window_(std::move(window)),
      healthy_(priors.healthy),
      known_(priors.sensors.validate().empty() ? priors.sensors : KnownSensors()),
      memory_(*memory),
      imu_(window_.imu().begin(), window_.imu().end()),
      budget_(options.limits) {}

InitResult SnapshotSolve::solve() { return healthy_.empty() ? start() : recover(); }

InitResult SnapshotSolve::start() {
  std::optional<InitResult> from_rest;
  if (options_.slim.start_from_rest && solver_.usesPriors()) {
    searchRest();
    from_rest = solveFromRest();
  }
  InitResult result = from_rest ? *std::move(from_rest) : solveNewest();
  if (short_window_ && !result.success()) offerProvisional(&result);
  return checked(std::move(result));
}

// Among the frames that are new since the solve before.
void SnapshotSolve::searchRest() {
  const WindowCut newest = window_.cut(everyImage(kMinKeyframes), 0);
  if (newest.window == nullptr) return;
  const double last = newest.window->times().back(), oldest = last - window_.options().fullSpan();
  const double searched = std::isnan(memory_.rest_searched) ? oldest : memory_.rest_searched;
  for (double t = last; t > std::max(searched, oldest); t -= kRestStep) {
    if (restUntil(t)) break;
  }
  memory_.rest_searched = last;
  if (memory_.rest.prior.state.t < oldest) memory_.rest = LastRest();
}

// The span of the images from `first` to `last` [s] if the body stands in them; NaN if not.
TimeSpan SnapshotSolve::restWithin(double first, double last, RestMeasures* rest) const {
  const WindowCut cut = withKnownSensors(window_.cutWithin(
      everyImage(std::numeric_limits<int>::max()), {first - KeyframeWindow::kSameStamp, last}));
  if (cut.window == nullptr) return {};
  const TimeSpan span = {cut.window->times().front(), cut.window->times().back()};
  if (span.last - span.first < kLeastOfSpan * (last - first)) return {};
  *rest = measureRest(*cut.window);
  const double G = cut.window->calibration().gravity_magnitude;
  return rest->isRest(G, options_.inertial) ? span : TimeSpan();
}

// Whether the body stands in the images up to `last` [s]; then that is the last rest.
bool SnapshotSolve::restUntil(double last) {
  RestMeasures rest;
  TimeSpan span = restWithin(last - 2.0 * kRestSpan, last, &rest);
  if (std::isnan(span.last)) span = restWithin(last - kRestSpan, last, &rest);
  if (std::isnan(span.last)) return false;
  LastRest& known = memory_.rest;
  const bool goes_on = known.until >= span.first;
  double since = goes_on ? known.since : span.first;
  // Of a rest that is new, the begin.
  for (RestMeasures before; !goes_on;) {
    const double middle = since + 0.5 * kRestSpan;
    const double first = restWithin(middle - kRestSpan, middle, &before).first;
    if (!(first < since)) break;
    since = first;
  }
  known.since = since;
  known.until = span.last;
  known.prior = priorAtRest(
      rest, span.last - kBeforeMotion, window_.calibration().gravity_magnitude,
      known_.empty() ? window_.calibration().imu_biases : known_.biases, options_.inertial);
  known.prior.calibration = known_.calibration;
  return true;
}

// The body at rest, and as long as there are too few keyframes after that: what is observable.
InitResult SnapshotSolve::stationary() const {
  const LastRest& rest = memory_.rest;
  InitResult result = refuse(InitStatus::kStationary,
                             roundedText(3, "at rest for ", rest.until - rest.since, " s"));
  result.gravity_w = Eigen::Vector3d(0.0, 0.0, -window_.calibration().gravity_magnitude);
  result.gravity_b0 = rest.prior.state.R_w_b.transpose() * result.gravity_w;
  result.gyro_bias = rest.prior.state.gyro_bias;
  return result;
}

// The first motion after a rest; nothing where the window has to be solved without it: there was no
// rest, or the data contradict it.
std::optional<InitResult> SnapshotSolve::solveFromRest() {
  const LastRest& rest = memory_.rest;
  if (std::isnan(rest.since)) return std::nullopt;
  if (rest.until == memory_.rest_searched || cutSince(rest.prior.state.t).window == nullptr) {
    return stationary();
  }
  InitResult result = solveWithPrior(rest.prior);
  const bool uncertain = isWait(result.status) || result.status == InitStatus::kScaleTooUncertain;
  // Which of them is wrong, rest or speeds, the window alone says.
  const bool no_speed_fits = 2 * result.speeds.contradicted > result.speeds.keyframes;
  if (!result.prior_dropped.empty() || no_speed_fits || !(result.success() || uncertain)) {
    return std::nullopt;
  }
  memory_.answers.judge(&result);
  if (result.success()) result.at_rest_since = rest.since;
  return result;
}

InitResult SnapshotSolve::recover() {
  std::string problem;
  std::vector<HealthyState> states = usableStates(&problem);
  if (states.empty()) return refuse(InitStatus::kInvalidInput, problem);
  InitResult alone;
  {
    const WorkBudget::Share share(kShareOfWindowAlone, &budget_);
    alone = checked(solveNewest());
  }
  for (HealthyState& state : states) state.test = compare(*state.prior, alone);
  const bool any = std::any_of(states.begin(), states.end(),
                               [](const HealthyState& state) { return state.agrees(); });
  if (alone.success() && (states.front().agrees() || !any)) {
    return continueFrame(states, std::move(alone));
  }
  InitResult known = solveWithPrior(*bestPrior(states).prior);
  if (known.success()) {
    known.frame_continued = true;
    return known;
  }
  if (short_window_ && !alone.success()) {
    offerProvisional(&alone);
    alone = checked(std::move(alone));
  }
  if (alone.success() || alone.provisional()) return continueFrame(states, std::move(alone));
  alone.message += "; with a known state: " + known.message;
  return alone;
}

// An estimate that contradicts its own status is none.
InitResult SnapshotSolve::checked(InitResult result) const {
  const std::string message = result.validate();
  if (message.empty()) return result;
  return refuse(InitStatus::kNumericalFailure, solver_.name() + " reported " + message);
}

InitResult SnapshotSolve::solveNewest() {
  const WindowCut cut = withKnownSensors(window_.cut());
  return cut.window == nullptr ? refuse(cut.status, cut.message) : answer(*cut.window);
}

// The window with what is known of the sensors.
WindowCut SnapshotSolve::withKnownSensors(WindowCut cut) const {
  if (cut.window == nullptr || known_.empty()) return cut;
  Calibration calibration = cut.window->calibration();
  if (known_.calibration) {
    calibration = withFound(calibration, *known_.calibration);
  }
  calibration.imu_biases = known_.biases;
  // A td that moves the keyframes away from the samples is none.
  if (const auto window = withCalibration(*cut.window, calibration)) cut.window = window;
  return cut;
}

// Judged by the answers before it.
InitResult SnapshotSolve::answer(const InitWindow& window) {
  InitResult result = solver_.solve(window, {}, &budget_);
  const double newest = window.times().back();
  if (result.success() && result.hasEstimate() &&
      !(std::abs(newest - memory_.last_solved) <= kSuccessive)) {
    solveEarlier(window.size(), result);
  }
  memory_.answers.judge(&result);
  memory_.last_solved = newest;
  failAtLimit(&budget_, &result);
  return result;
}

// A host that solves at every image has earlier answers to agree with. One that solves now and then
// has none: the window is solved as it was before its newest keyframes.
void SnapshotSolve::solveEarlier(int keyframes, const InitResult& result) {
  const bool refused_before = memory_.answers.refusedBefore();
  memory_.answers.reset();
  const std::vector<NavState>& states = result.states;
  if (!refused_before && states.back().t - states.front().t >=
                             ConsistencyCheck::kFullFraction * window_.options().fullSpan())
    return;
  // Keyframes that td has moved past the IMU are in neither answer.
  const int lost = std::max(0, keyframes - static_cast<int>(states.size()));
  for (int earlier = ConsistencyCheck::kEarlierEstimates; earlier > 0; --earlier) {
    const WindowCut before = withKnownSensors(window_.cut(lost + earlier));
    if (before.window == nullptr) continue;
    if (!budget_.allows(kEarlier)) return;
    InitResult answer = solver_.solve(*before.window, {}, &budget_);
    memory_.answers.judge(&answer);
    if (answer.status == InitStatus::kTimeLimit) budget_.leaveOut(kEarlier);
  }
}

// What a host that takes a prior can start with. Where there is nothing, `result` keeps its own
// reason.
void SnapshotSolve::offerProvisional(InitResult* result) {
  const WindowCut cut = withKnownSensors(window_.cut(*short_window_, 0));
  if (cut.window == nullptr) return;
  SolveRequest request;
  request.provisional = true;
  const InitResult now = solver_.solve(*cut.window, request, &budget_);
  if (!now.provisional()) return;
  // As it was before the newest third of the data.
  const int third = std::max(1, cut.window->size() / 3);
  const WindowCut before = withKnownSensors(window_.cut(*short_window_, third));
  if (before.window == nullptr) return;
  if (agrees(solver_.solve(*before.window, request, &budget_), now)) *result = now;
}

// The newest first. If there is none, `problem` is that of the newest.
std::vector<SnapshotSolve::HealthyState> SnapshotSolve::usableStates(std::string* problem) const {
  std::vector<HealthyState> states;
  for (auto prior = healthy_.rbegin(); prior != healthy_.rend(); ++prior) {
    const std::string found = checkHealthy(*prior);
    if (found.empty()) {
      states.push_back({&*prior, StateTest()});
    } else if (prior == healthy_.rbegin()) {
      *problem = found;
    }
  }
  return states;
}

WindowCut SnapshotSolve::cutSince(double first) const {
  return window_.cutWithin(window_.options(), {first, std::numeric_limits<double>::infinity()});
}

StatePrior SnapshotSolve::carried(const StatePrior& prior, double t) const {
  const Calibration& calibration = window_.calibration();
  return propagatePrior(prior, t, imu_, calibration.gravity_magnitude, calibration.imu_noise);
}

// Both at the later of two times: that of the healthy state, and that of the first keyframe.
// Nothing is contradicted by an estimate that is not known with a covariance.
StateTest SnapshotSolve::compare(const StatePrior& healthy, const InitResult& alone) const {
  if (!hasCovarianceOfItsErrors(alone)) return StateTest();
  const std::size_t k = lastUntil(healthy.state.t, alone.states);
  StatePrior estimate;
  estimate.state = alone.states[k];
  estimate.covariance = alone.stateCovariance(k);
  const double t = std::max(estimate.state.t, healthy.state.t);
  if (!estimate.covariance.allFinite() || !checkGap(healthy.state.t, t).empty()) return StateTest();
  const StateFactor known = stateFactor(carried(healthy, t));
  return testDifference(known, stateFactor(carried(estimate, t)));
}

// The newest that agrees, or else of which the velocity agrees, or else the newest; of those after
// which there are enough frames.
const SnapshotSolve::HealthyState& SnapshotSolve::bestPrior(
    const std::vector<HealthyState>& states) const {
  const HealthyState* best = nullptr;
  int best_rank = 0;
  for (const HealthyState& state : states) {
    const int rank = state.agrees() ? 3 : state.test.contradicts(StatePart::kVelocity) ? 1 : 2;
    if (rank <= best_rank || cutSince(state.prior->state.t).window == nullptr) continue;
    best = &state;
    best_rank = rank;
  }
  return best == nullptr ? states.back() : *best;
}

// From the frames after a known state.
InitResult SnapshotSolve::solveWithPrior(const StatePrior& prior) {
  const WindowCut cut = cutSince(prior.state.t);
  if (cut.window == nullptr) return refuse(cut.status, cut.message);
  const double first = cut.window->times().front();
  if (const std::string gap = checkGap(prior.state.t, first); !gap.empty()) {
    return refuse(InitStatus::kInvalidInput, gap);
  }
  const StatePrior state = carried(prior, first);
  return checked(solver_.solve(*cut.window, {&state}, &budget_));
}

// Where the IMU data cannot carry a state over this time, why; or "".
std::string SnapshotSolve::checkGap(double from, double to) const {
  double gap = 0.0;
  for (std::size_t i = 1; i < imu_.size(); ++i) {
    if (imu_[i].t > from && imu_[i - 1].t < to) gap = std::max(gap, imu_[i].t - imu_[i - 1].t);
  }
  if (!(gap > window_.options().max_imu_gap_s)) return "";
  return text("gap in the IMU data between the last healthy state and the window ", gap,
              " s (limit ", window_.options().max_imu_gap_s, " s)");
}

// Why nothing can continue this state, or "".
std::string SnapshotSolve::checkHealthy(const StatePrior& healthy) const {
  if (const std::string problem = healthy.validate(); !problem.empty()) return problem;
  const double t = healthy.state.t;
  if (!imu_.empty() && t >= imu_.front().t && t <= imu_.back().t) return "";
  const std::string message =
      text("the last healthy state at ", std::fixed, t, " s lies outside the buffered IMU data");
  if (imu_.empty()) return message;
  return message + text(std::fixed, " [", imu_.front().t, ", ", imu_.back().t, "] s");
}

// `alone`, a success or provisional, in the frame of the newest state that agrees, or else of the
// newest, with the parts of it named that it contradicts.
InitResult SnapshotSolve::continueFrame(const std::vector<HealthyState>& states,
                                        InitResult alone) const {
  const HealthyState* from = nullptr;
  std::string gap;
  for (const HealthyState& state : states) {
    // Between the healthy state and the window the IMU alone carries the frame.
    gap = checkGap(state.prior->state.t, alone.states.front().t);
    if (!gap.empty()) break;
    if (from == nullptr || (!from->agrees() && state.agrees())) from = &state;
  }
  if (from == nullptr) return refuse(InitStatus::kInvalidInput, gap);
  continueFrom(*from, &alone);
  alone.frame_continued = true;
  if (from->agrees()) return alone;
  for (int i = 0; i < kStateParts; ++i) {
    const auto part = static_cast<StatePart>(i);
    if (from->test.contradicts(part)) alone.prior_dropped.push_back(toString(part));
  }
  alone.message += text("; the last healthy state differs by ", std::sqrt(from->test.total),
                        " standard deviations (limit ", std::sqrt(from->test.bound()),
                        ") and gives position and yaw alone");
  return alone;
}

// Moves the new solution into the old odometry frame: both describe the body at one time, the
// first at which both exist.
void SnapshotSolve::continueFrom(const HealthyState& healthy, InitResult* result) const {
  NavState there = healthy.prior->state;
  const std::size_t k = lastUntil(there.t, result->states);
  NavState here = result->states[k];
  if (healthy.test.contradicts(StatePart::kVelocity) && there.t < here.t) {
    // A wrong velocity would carry the frame away: the new one leads back.
    StateAtOptions back;
    back.max_reach_s = here.t - there.t;
    back.max_imu_gap_s = window_.options().max_imu_gap_s;
    std::vector<NavState> at;
    if (statesAt(*result, imu_, {there.t}, back, &at, nullptr)) {
      moveToFrame(there, at.front(), result);
      return;
    }
  }
  // The biases that are better known carry the old state on.
  const Eigen::Matrix<double, 15, 15> P = result->stateCovariance(k);
  const auto keepsBias = [&](int row, StatePart part) {
    const double old_variance = healthy.prior->covariance.diagonal().segment<3>(row).sum();
    return old_variance > 0.0 && old_variance < P.diagonal().segment<3>(row).sum() &&
           !healthy.test.contradicts(part);
  };
  if (!keepsBias(9, StatePart::kGyroBias)) there.gyro_bias = here.gyro_bias;
  if (!keepsBias(12, StatePart::kAccelBias)) there.accel_bias = here.accel_bias;
  there = propagateTo(there, here.t, imu_, result->gravity_w);
  here = propagateTo(here, there.t, imu_, result->gravity_w);
  moveToFrame(there, here, result);
}

}  // namespace slim_init
