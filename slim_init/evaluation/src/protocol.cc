// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/protocol.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <future>
#include <memory>
#include <utility>

#include "slim_init/consistency_check.h"
#include "slim_init/evaluation/cpu_time.h"
#include "slim_init/evaluation/rig_errors.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/host_health/imu_screen.h"
#include "slim_init/keyframe_window.h"

namespace slim_init::evaluation {
namespace {

// A trial that has no full window after this many nominal lengths has met a gap.
constexpr double kGiveUpLengths = 2.0;
// A window is full when it lacks less than this share of the time between two images.
constexpr double kFullTolerance = 0.99;

enum class CutOutcome { kWindow, kEnded, kInterrupted, kInvalid };

struct Cut {
  CutOutcome outcome = CutOutcome::kEnded;
  std::vector<std::shared_ptr<const InitWindow>> windows;  ///< one an image; the last one is full
  std::string message;                                     ///< of a refusal

  const InitWindow& full() const { return *windows.back(); }
};

/// Runs the trials of one sequence. Every trial starts from a fresh KeyframeWindow, so that a
/// window depends on its own data only.
class WindowCutter {
 public:
  /// Windows have at least `first_keyframes`; zero: full ones only.
  WindowCutter(const Sequence& sequence, const WindowOptions& options, const ImuLimits& imu,
               int first_keyframes)
      : sequence_(sequence), options_(options) {
    streams_.imu = imu;
    std::vector<double> intervals;
    for (std::size_t i = 1; i < sequence.frames.size(); ++i) {
      intervals.push_back(sequence.frames[i].t - sequence.frames[i - 1].t);
    }
    // Keyframes fall on images: at 20 Hz, 0.22 s between them become 0.25 s.
    const double frame_interval = intervals.empty() ? options.min_interval_s : median(intervals);
    const double spacing =
        frame_interval * std::max(1.0, std::ceil(options.min_interval_s / frame_interval - 1e-6));
    frame_interval_ = frame_interval;
    give_up_s_ = kGiveUpLengths * std::max(options.max_span_s, (options.keyframes - 1) * spacing);
    growing_ = first_keyframes > 0;
    options_.min_keyframes = growing_ ? first_keyframes : options.keyframes;
    options_.buffer_s = std::max(options.buffer_s, give_up_s_ + 1.0);
  }

  /// Feeds frames from `first_frame` on until a full window can be cut, by a system that believes
  /// in `calibration`.
  Cut cut(std::size_t first_frame, const Calibration& calibration, StreamCounts* dropped) const {
    KeyframeWindow buffer(calibration, options_, streams_);
    host_health::ImuScreen screen(streams_.imu);
    const auto imuTime = [&](std::size_t frame) {
      return calibration.imuTime(sequence_.frames[frame].t);
    };
    const double t_first = imuTime(first_frame);
    std::size_t next_imu = lastSampleAtOrBefore(t_first - InitWindow::kImuMargin);
    auto speed = std::lower_bound(sequence_.speeds.begin(), sequence_.speeds.end(),
                                  t_first - InitWindow::kMaxSpeedGap,
                                  [](const SpeedSample& sample, double t) { return sample.t < t; });
    Cut result;
    for (std::size_t i = first_frame; i < sequence_.frames.size(); ++i) {
      const double elapsed = imuTime(i) - t_first;
      if (elapsed > give_up_s_) {
        result.outcome = CutOutcome::kInterrupted;
        break;
      }
      // Past the frame by the margin with which keyframes can be moved by an error of td.
      while (
          next_imu < sequence_.imu.size() &&
          (buffer.imu().empty() || buffer.imu().back().t < imuTime(i) + InitWindow::kImuMargin)) {
        screen.pass(sequence_.imu[next_imu++],
                    [&buffer](const ImuSample& sample) { return buffer.addImu(sample); });
      }
      const double until = imuTime(i) + InitWindow::kMaxSpeedGap;
      for (; speed != sequence_.speeds.end() && speed->t < until; ++speed) buffer.addSpeed(*speed);
      buffer.addFrame(sequence_.frames[i]);
      // cut() copies the window's data: asked only when there can be one.
      if (elapsed < (options_.min_keyframes - 1) * options_.min_interval_s - 1e-9) continue;
      const WindowCut cut = buffer.cut();
      if (cut.status == InitStatus::kInvalidInput) {
        result.outcome = CutOutcome::kInvalid;
        result.message = cut.message;
        break;
      }
      if (cut.window == nullptr) continue;
      const bool full = isFull(*cut.window);
      if (full || growing_) result.windows.push_back(cut.window);
      if (full) {
        result.outcome = CutOutcome::kWindow;
        break;
      }
    }
    *dropped += buffer.counts();
    dropped->imu[AddStatus::kGlitch] += screen.discarded();
    return result;
  }

 private:
  // The next image would not make it longer.
  bool isFull(const InitWindow& window) const {
    const double span = window.times().back() - window.times().front();
    return window.size() == options_.keyframes &&
           span + kFullTolerance * frame_interval_ > options_.max_span_s;
  }

  std::size_t lastSampleAtOrBefore(double t) const {
    const auto after =
        std::upper_bound(sequence_.imu.begin(), sequence_.imu.end(), t,
                         [](double time, const ImuSample& sample) { return time < sample.t; });
    const auto index = static_cast<std::size_t>(after - sequence_.imu.begin());
    return index > 0 ? index - 1 : 0;
  }

  const Sequence& sequence_;
  WindowOptions options_;
  StreamOptions streams_;
  bool growing_ = false;
  double frame_interval_ = 0.0;
  double give_up_s_ = 0.0;
};

/// Truth at every keyframe, with a time that is NaN where there is none. Empty for a sequence
/// without any truth.
std::vector<NavState> truthOfWindow(const Sequence& sequence, const InitWindow& window) {
  std::vector<NavState> truth;
  if (sequence.truth == nullptr) return truth;
  for (const double t : window.times()) truth.push_back(truthAt(sequence, t));
  return truth;
}

/// Errors of an answer against the truth at the times of its own states: a method that estimates td
/// moves them away from the keyframes of the window, and may leave out one that the IMU data then
/// do not cover. `without_truth`: one of them lies where there is no truth, and yet as near to the
/// window as a correction of td may take it. Without states: against the truth at the keyframes.
WindowMetrics evaluateEstimate(const Sequence& sequence, const InitWindow& window,
                               const InitResult& answer, bool* without_truth) {
  WindowMetrics metrics;
  if (sequence.truth == nullptr) {
    metrics.failure = "no ground truth";
    return metrics;
  }
  if (answer.states.empty()) return evaluateWindow(answer, truthOfWindow(sequence, window));
  std::vector<NavState> truth;
  for (const NavState& state : answer.states) {
    truth.push_back(truthAt(sequence, state.t));
    if (std::isfinite(truth.back().t)) continue;
    *without_truth = state.t > window.times().front() - InitWindow::kImuMargin &&
                     state.t < window.times().back() + InitWindow::kImuMargin;
    metrics.failure = std::isfinite(state.t) ? "no ground truth at " + std::to_string(state.t) +
                                                   " s, the time of a state"
                                             : "the time of a state is not finite";
    return metrics;
  }
  return evaluateWindow(answer, truth);
}

MethodRecord runSolver(const WindowSolver& solver, const InitWindow& window,
                       const Sequence& sequence, ConsistencyCheck* answers) {
  MethodRecord record;
  InitResult& answer = record.answer;
  const double cpu_begin = threadCpuMs();
  const auto begin = std::chrono::steady_clock::now();
  answer = solver.solve(window);
  answers->judge(&answer);
  const auto end = std::chrono::steady_clock::now();
  const double cpu_end = threadCpuMs();

  record.keyframes = window.size();
  record.data_s = window.times().back() - window.times().front();
  record.solve_ms = std::chrono::duration<double, std::milli>(end - begin).count();
  record.solve_cpu_ms = cpu_end - cpu_begin;
  record.metrics = evaluateEstimate(sequence, window, answer, &record.without_truth);
  if (answer.calibration.has_value()) {
    record.calibration = evaluateCalibration(*answer.calibration, sequence.trueCalibration());
  }
  answer.covariance.resize(0, 0);  // of all that is kept by far the largest
  return record;
}

/// Whether every keyframe of every window of a trial has ground truth, or none is expected.
bool hasTruth(const Sequence& sequence, const Cut& cut) {
  for (const auto& window : cut.windows) {
    for (const NavState& state : truthOfWindow(sequence, *window)) {
      if (!std::isfinite(state.t)) return false;
    }
  }
  return true;
}

/// A window on its way from being cut to its record.
struct Trial {
  Calibration calibration;  ///< as the methods are told
  Cut cut;
  std::shared_ptr<const InitWindow> judged;  ///< by its excitation
  WindowRecord record;
};

/// The first window that the solver accepts, or else the full one; and what becomes of it.
MethodRecord runSolver(const WindowSolver& solver, const Trial& trial, const Sequence& sequence,
                       const ProtocolOptions& options) {
  MethodRecord record;
  ConsistencyCheck answers(options.window.fullSpan(),
                           options.first_keyframes > 0 ? ConsistencyCheck::kMaxDisagreement : 0.0);
  for (const auto& window : trial.cut.windows) {
    record = runSolver(solver, *window, sequence, &answers);
    if (record.accepted()) break;
  }
  if (options.downstream && record.accepted()) {
    record.downstream = options.downstream(sequence, trial.calibration, record.answer);
  }
  return record;
}

/// Counts what became of a trial; true where it is a window to be solved, whose record then says
/// when and where it begins.
bool countTrial(const Sequence& sequence, std::vector<double>* times_before, Trial* trial,
                ProtocolResult* result) {
  ProtocolCounts& counts = result->counts;
  const Cut& cut = trial->cut;
  ++counts.trials;
  if (cut.outcome != CutOutcome::kWindow) {
    ++(cut.outcome == CutOutcome::kEnded         ? counts.ended
       : cut.outcome == CutOutcome::kInterrupted ? counts.interrupted
                                                 : counts.invalid);
    if (result->first_refusal.empty()) result->first_refusal = cut.message;  // of an invalid one
    return false;
  }
  const std::vector<double>& times = cut.full().times();
  if (times == *times_before) {
    ++counts.repeated;
    return false;
  }
  *times_before = times;
  if (!hasTruth(sequence, cut)) {
    ++counts.without_truth;
    return false;
  }
  WindowRecord& record = trial->record;
  record.t_start = times.front();
  record.t_start_ns = sequence.t0_ns + std::llround(1e9 * record.t_start);
  record.duration_s = times.back() - times.front();
  record.keyframes = cut.full().size();
  record.rig = calibrationDifference(trial->calibration, sequence.trueCalibration());
  return true;
}

/// Keeps the record of a window that can be judged for every method, so that all methods are
/// compared on the same windows. False for another one.
bool takeRecord(WindowRecord record, ProtocolResult* result) {
  const bool judged = std::none_of(record.methods.begin(), record.methods.end(),
                                   [](const MethodRecord& m) { return m.without_truth; });
  ++(judged ? result->counts.windows : result->counts.not_evaluable);
  if (judged) result->windows.push_back(std::move(record));
  return judged;
}

}  // namespace

ProtocolResult runProtocol(const Sequence& sequence,
                           const std::vector<const WindowSolver*>& solvers,
                           const ProtocolOptions& options, const ProgressCallback& progress) {
  ProtocolResult result;
  result.has_truth = sequence.truth != nullptr;
  result.first_keyframes = options.first_keyframes;
  for (const WindowSolver* solver : solvers) result.methods.push_back(solver->name());
  result.counts.frames = static_cast<int>(sequence.frames.size());
  const WindowCutter cutter(sequence, options.window, options.imu, options.first_keyframes);
  // Which trials are excited does not depend on the windows that the methods get.
  const WindowCutter paper_cutter(sequence, paperWindow(), options.imu, 0);
  const auto windowOfExcitation = [&](std::size_t first_frame, const Trial& trial) {
    if (options.first_keyframes == 0) return trial.cut.windows.back();
    StreamCounts ignored;
    const Cut cut = paper_cutter.cut(first_frame, trial.calibration, &ignored);
    return cut.outcome == CutOutcome::kWindow ? cut.windows.back() : trial.cut.windows.back();
  };
  const int trials = (result.counts.frames + options.stride - 1) / options.stride;
  // With a limit the end is near after about as many trials.
  const int expected = options.max_windows > 0 ? std::min(trials, options.max_windows) : trials;
  std::vector<double> times_before;
  int windows_cut = 0;  // but those that cannot be judged
  // Windows that are being solved, oldest first. Last, so that it ends before what it refers to. If
  // the system gives no thread, get() solves.
  std::deque<std::future<WindowRecord>> running;
  const auto policy =
      options.threads > 1 ? std::launch::async | std::launch::deferred : std::launch::deferred;
  const auto finishOldest = [&] {
    if (!takeRecord(running.front().get(), &result)) --windows_cut;
    running.pop_front();
  };

  for (int index = 0; index < trials; ++index) {
    while (windows_cut >= expected && !running.empty()) finishOldest();
    if (windows_cut >= expected) break;
    const auto trial = std::make_shared<Trial>();
    const std::size_t first_frame =
        static_cast<std::size_t>(index) * static_cast<std::size_t>(options.stride);
    trial->record.trial = index;
    trial->calibration = options.rig.random
                             ? assumedCalibration(sequence.trueCalibration(), options.rig, index)
                             : sequence.calibration;
    trial->cut = cutter.cut(first_frame, trial->calibration, &result.dropped);
    if (progress) progress(std::min(index + 1, expected), expected);
    if (!countTrial(sequence, &times_before, trial.get(), &result)) continue;
    ++windows_cut;
    trial->judged = windowOfExcitation(first_frame, *trial);
    if (running.size() >= static_cast<std::size_t>(options.threads)) finishOldest();
    running.push_back(std::async(policy, [&, trial] {
      trial->record.excitation = measureExcitation(*trial->judged);
      for (const WindowSolver* solver : solvers) {
        trial->record.methods.push_back(runSolver(*solver, *trial, sequence, options));
      }
      return std::move(trial->record);
    }));
  }
  while (!running.empty()) finishOldest();
  return result;
}

}  // namespace slim_init::evaluation
