// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/initializer.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "data/with_calibration.h"
#include "imu/carry_prior.h"
#include "imu/preintegration.h"
#include "join_frame.h"
#include "provisional.h"
#include "slim_init/answer_sequence.h"
#include "slim_init/keyframe_window.h"
#include "slim_init/state_at.h"

namespace slim_init {
namespace {

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

// States of a history that are tried, the newest first.
constexpr int kMostTries = 3;

class Initializer : public IInitializer {
 public:
  Initializer(std::unique_ptr<WindowSolver> solver, const Calibration& calibration,
              const InitializerOptions& options)
      : solver_(std::move(solver)),
        window_(calibration, options.window, StreamOptions::liveData(options.imu)),
        answers_(options.window.fullSpan(), AnswerSequence::kMaxDisagreement) {
    if (!options.provisional.enabled) return;
    young_.emplace(calibration, youngWindow(options), StreamOptions::liveData(options.imu));
  }

  const std::string& name() const override { return solver_->name(); }
  AddStatus addImu(const ImuSample& sample) override {
    if (young_) young_->addImu(sample);
    return noted(window_.addImu(sample));
  }
  AddStatus addFrame(FrameObservation frame) override {
    if (young_) young_->addFrame(frame);
    return noted(window_.addFrame(std::move(frame)));
  }
  AddStatus addLines(double stamp, std::vector<LineObservation> lines) override {
    if (young_) young_->addLines(stamp, lines);
    return window_.addLines(stamp, std::move(lines));
  }
  void setTd(double td) override {
    if (std::abs(td - window_.calibration().td) > kSameTd) forgetAnswers();
    if (young_) young_->setTd(td);
    window_.setTd(td);
  }
  void setKnownSensors(const KnownSensors& known) override {
    if (!known.validate().empty()) return;
    const bool knows = known.calibration.has_value() || std::isfinite(known.biases.gyro_sigma) ||
                       std::isfinite(known.biases.accel_sigma);
    if (knows || knows_) young_answers_.clear();
    known_ = known;
    knows_ = knows;
  }
  void reset() override {
    if (young_) young_->reset();
    window_.reset();
    forgetAnswers();
  }

  InitResult initialize() override {
    const WindowCut cut = informed(window_.cut());
    InitResult result =
        cut.window == nullptr ? refuse(cut.status, cut.message) : answer(*cut.window);
    if (young_ && !result.success()) offerProvisional(&result);
    if (const std::string message = result.validate(); !message.empty()) {
      return refuse(InitStatus::kNumericalFailure, name() + " reported " + message);
    }
    return result;
  }

  InitResult recover(const NavState& last_healthy) override {
    const std::string problem = checkHealthy(last_healthy);
    if (!problem.empty()) return refuse(InitStatus::kInvalidInput, problem);
    InitResult result = initialize();
    if (!result.success() && !result.provisional()) return result;
    // Between the healthy state and the window the IMU alone carries the frame.
    const std::vector<ImuSample> imu = bufferedSamples();
    if (const std::string gap = checkGap(last_healthy.t, result.states.front().t, imu);
        !gap.empty()) {
      return refuse(InitStatus::kInvalidInput, gap);
    }
    join(last_healthy, imu, &result);
    return result;
  }

  InitResult recoverWithPrior(const std::vector<StatePrior>& healthy) override {
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

  bool statesAt(const InitResult& result, const std::vector<double>& times, double max_reach_s,
                std::vector<NavState>* states, std::string* error) const override {
    StateAtOptions options;
    options.max_reach_s = max_reach_s;
    options.max_imu_gap_s = window_.options().max_imu_gap_s;
    return slim_init::statesAt(result.states, result.gravity_w, bufferedSamples(), times, options,
                               states, error);
  }

  Calibration calibration() const override { return window_.calibration(); }
  StreamCounts counts() const override { return window_.counts(); }
  TimeSpan bufferedImu() const override {
    return window_.imu().empty() ? TimeSpan{}
                                 : TimeSpan{window_.imu().front().t, window_.imu().back().t};
  }
  double maxWindowSpan() const override {
    const WindowOptions& options = window_.options();
    return std::max(options.max_span_s, options.keyframes * options.min_interval_s);
  }

 private:
  // Answers before and after a change of td by more than this are not compared [s]: the standard
  // deviation of a td that is known.
  static constexpr double kSameTd = 1e-3;
  // A question this long after the one before is asked anew [s]: two images at 10 Hz, and a half.
  static constexpr double kSuccessive = 0.25;

  // What tells young windows apart while nothing is forgotten. Lines may come after their frame.
  struct YoungKey {
    explicit YoungKey(const InitWindow& window)
        : times(window.times()), td(window.calibration().td) {
      for (int k = 0; k < window.size(); ++k) lines += window.linesOfKeyframe(k).size();
    }
    bool operator==(const YoungKey& other) const {
      return times == other.times && td == other.td && lines == other.lines;
    }

    std::vector<double> times;  // of the keyframes [s]
    double td;                  // [s]
    std::size_t lines = 0;
  };

  // The answer of the solver to a young window.
  struct YoungAnswer {
    YoungKey key;
    InitResult answer;
  };

  // Young windows, of every image.
  static WindowOptions youngWindow(const InitializerOptions& options) {
    WindowOptions young = options.window;
    young.keyframes = options.provisional.keyframes;
    young.min_keyframes = kMinKeyframes;
    young.min_interval_s = options.provisional.min_interval_s;
    young.max_span_s = 0.0;
    return young;
  }

  // With what is known of the sensors.
  WindowCut informed(WindowCut cut) const {
    if (cut.window == nullptr || !knows_) return cut;
    Calibration calibration = cut.window->calibration();
    if (known_.calibration) calibration = withFound(calibration, *known_.calibration);
    calibration.imu_biases = known_.biases;
    // A td that moves the keyframes away from the samples is none.
    if (const auto window = withCalibration(*cut.window, calibration)) cut.window = window;
    return cut;
  }

  // From the frames after a known state.
  InitResult answerWithPrior(const StatePrior& prior) const {
    std::string problem = prior.validate();
    if (problem.empty()) problem = checkHealthy(prior.state);
    if (!problem.empty()) return refuse(InitStatus::kInvalidInput, problem);
    const WindowCut cut = window_.cutSince(prior.state.t);
    if (cut.window == nullptr) return refuse(cut.status, cut.message);
    const std::vector<ImuSample> imu = bufferedSamples();
    const double first = cut.window->times().front();
    if (const std::string gap = checkGap(prior.state.t, first, imu); !gap.empty()) {
      return refuse(InitStatus::kInvalidInput, gap);
    }
    const Calibration& calibration = window_.calibration();
    InitResult result = solver_->solveWithPrior(
        *cut.window,
        carryPrior(prior, first, imu, calibration.gravity_magnitude, calibration.imu_noise));
    if (const std::string message = result.validate(); !message.empty()) {
      return refuse(InitStatus::kNumericalFailure, name() + " reported " + message);
    }
    return result;
  }

  // Where the IMU data cannot carry a state over this time, why; or "".
  std::string checkGap(double from, double to, const std::vector<ImuSample>& imu) const {
    const double gap = largestGap(imu, from, to);
    if (!(gap > window_.options().max_imu_gap_s)) return "";
    std::ostringstream message;
    message << "gap in the IMU data between the last healthy state and the window " << gap
            << " s (limit " << window_.options().max_imu_gap_s << " s)";
    return message.str();
  }

  // What a host that takes a prior can start with. Where there is nothing, `result` keeps its own
  // reason.
  void offerProvisional(InitResult* result) {
    const WindowCut cut = informed(young_->cut());
    if (cut.window == nullptr) return;
    const InitResult young = youngAnswer(*cut.window);
    if (!young.provisional()) return;
    // As it was before the newest third of the data.
    const WindowCut before = informed(young_->cut(std::max(1, cut.window->size() / 3)));
    if (before.window == nullptr) return;
    if (agrees(youngAnswer(*before.window), young)) *result = young;
  }

  // While the window grows, a host that asks at every image has asked for the earlier one already.
  InitResult youngAnswer(const InitWindow& window) {
    const YoungKey key(window);
    for (const YoungAnswer& known : young_answers_) {
      if (known.key == key) return known.answer;
    }
    if (static_cast<int>(young_answers_.size()) >= young_->options().keyframes) {
      young_answers_.pop_front();
    }
    young_answers_.push_back({key, solver_->solveProvisional(window)});
    return young_answers_.back().answer;
  }

  // Judged by the answers before it.
  InitResult answer(const InitWindow& window) {
    InitResult result = solver_->solve(window);
    const double newest = window.times().back();
    if (result.success() && result.hasEstimate() &&
        !(std::abs(newest - last_question_) <= kSuccessive)) {
      answerEarlier(window.size(), result);
    }
    answers_.judge(&result);
    last_question_ = newest;
    return result;
  }

  AddStatus noted(AddStatus status) {
    if (status == AddStatus::kRestarted) forgetAnswers();
    return status;
  }

  void forgetAnswers() {
    answers_.reset();
    young_answers_.clear();
    last_question_ = kNotComputed;
  }

  // A host that asks at every image is told by its earlier questions whether answers agree. One
  // that asks now and then has none: the window is answered as it was before its newest keyframes.
  void answerEarlier(int keyframes, const InitResult& result) {
    answers_.reset();
    const std::vector<NavState>& states = result.states;
    if (states.back().t - states.front().t >=
        AnswerSequence::kFullShare * window_.options().fullSpan())
      return;
    // Keyframes that td has moved past the IMU are in neither answer.
    const int lost = std::max(0, keyframes - static_cast<int>(states.size()));
    for (int earlier = AnswerSequence::kEarlierAnswers; earlier > 0; --earlier) {
      const WindowCut before = informed(window_.cut(lost + earlier));
      if (before.window == nullptr) continue;
      InitResult answer = solver_->solve(*before.window);
      answers_.judge(&answer);
    }
  }

  static InitResult refuse(InitStatus status, const std::string& message) {
    InitResult result;
    result.status = status;
    result.message = message;
    return result;
  }

  std::vector<ImuSample> bufferedSamples() const {
    return std::vector<ImuSample>(window_.imu().begin(), window_.imu().end());
  }

  // Why nothing can be joined to this state, or "".
  std::string checkHealthy(const NavState& last_healthy) const {
    StatePrior state;
    state.state = last_healthy;
    if (const std::string problem = state.validate(); !problem.empty()) return problem;
    const TimeSpan imu = bufferedImu();
    if (!(last_healthy.t >= imu.first && last_healthy.t <= imu.last)) {
      std::ostringstream message;
      message << "the last healthy state at " << std::fixed << last_healthy.t
              << " s lies outside the buffered IMU data";
      if (!window_.imu().empty()) message << " [" << imu.first << ", " << imu.last << "] s";
      return message.str();
    }
    return "";
  }

  // Moves the new solution into the old odometry frame: both describe the body at one instant, the
  // first at which both exist.
  void join(const NavState& last_healthy, const std::vector<ImuSample>& imu,
            InitResult* result) const {
    const ImuNoise& noise = window_.calibration().imu_noise;
    NavState old_state = last_healthy;
    // The host's biases may be what failed; the new ones carry the old state on.
    NavState new_state = result->states.front();
    for (const NavState& state : result->states) {
      if (state.t <= last_healthy.t) new_state = state;
    }
    old_state.gyro_bias = new_state.gyro_bias;
    old_state.accel_bias = new_state.accel_bias;
    old_state = propagateTo(old_state, new_state.t, imu, result->gravity_w, noise);
    new_state = propagateTo(new_state, old_state.t, imu, result->gravity_w, noise);
    joinFrame(old_state, new_state, result);
  }

  std::unique_ptr<WindowSolver> solver_;
  KeyframeWindow window_;
  AnswerSequence answers_;
  KnownSensors known_;
  bool knows_ = false;                   // that there is something in it
  double last_question_ = kNotComputed;  // newest keyframe [s]
  std::optional<KeyframeWindow> young_;  // where provisional answers are wanted
  std::deque<YoungAnswer> young_answers_;
};

}  // namespace

std::unique_ptr<IInitializer> makeInitializer(std::unique_ptr<WindowSolver> solver,
                                              const Calibration& calibration,
                                              const InitializerOptions& options,
                                              std::string* error) {
  std::string message;
  if (solver == nullptr) {
    message = "the solver is null";
  } else if (message = calibration.validate(); !message.empty()) {
    message = "calibration: " + message;
  } else if (message = options.window.validate(); !message.empty()) {
    message = "window." + message;
  } else if (message = options.imu.validate(); !message.empty()) {
    message = "imu." + message;
  } else if (message = options.provisional.validate(); !message.empty()) {
    message = "provisional." + message;
  }
  if (!message.empty()) {
    if (error != nullptr) *error = message;
    return nullptr;
  }
  return std::make_unique<Initializer>(std::move(solver), calibration, options);
}

std::unique_ptr<IInitializer> makeInitializer(const Calibration& calibration,
                                              const InitializerOptions& options,
                                              std::string* error) {
  std::unique_ptr<WindowSolver> solver = makeSlimSolver(options, error);
  if (solver == nullptr) return nullptr;
  return makeInitializer(std::move(solver), calibration, options, error);
}

}  // namespace slim_init
